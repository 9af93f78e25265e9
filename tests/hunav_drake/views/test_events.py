import numpy as np

from hunav_drake.systems.common.layout import RADIUS, VX, YAW, X
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.views.events import events_of


def recorded(last=-1.0, **more):
    """A robot that drives to a person, waits there, and drives back."""
    times = np.arange(0.0, 12.01, 0.1)
    speed = np.where(times < 4.0, 1.0, np.where(times < 7.0, 0.0, last))
    robot = np.zeros((len(times), 7))
    robot[1:, X] = np.cumsum(speed[:-1] * 0.1)
    robot[:, VX], robot[:, RADIUS] = speed, 0.3
    humans = np.zeros((len(times), 1, 7))
    humans[:, 0, X], humans[:, 0, RADIUS] = 4.6, 0.3
    humans[:, 0, YAW] = np.pi
    return Recording(
        times=times, robot=robot, humans=humans, human_names=["ana"], **more
    )


def test_contacts_entries_reactions_and_stops_are_told_by_their_time():
    status = np.zeros((121, 1))
    status[30:80] = 1
    events = events_of(recorded(behavior_status=status))
    assert [(text, kind) for text, _, kind in events] == [
        ("personal space of ana entered", "entry"),
        ("ana reacts", "reaction"),
        ("intimate space of ana entered", "entry"),
        ("contact of ana", "contact"),
        ("the robot stops", "stop"),
    ]
    np.testing.assert_allclose(
        [time for _, time, _ in events], [2.8, 3.0, 3.55, 3.98, 4.0], atol=0.05
    )


def test_who_stands_at_its_goal_does_not_stop():
    assert "stop" in [kind for *_, kind in events_of(recorded())]
    assert "stop" not in [kind for *_, kind in events_of(recorded(last=0.0))]
