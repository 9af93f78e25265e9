"""Contacts of the robot with people, attributed to the one who approached."""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import VX, VY, X, Y
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics.goal import SEAN
from hunav_drake.systems.evaluation.recording import Recording

# Approach speeds that differ by less are equal, in m/s.
SPEED_RESOLUTION = 1e-6


def charged(recording: Recording, *, to_robot: bool) -> Mask:
    """Returns where a contact begins that is attributed to robot or person.

    With n the unit vector from robot to person, the robot approaches at a = v_r
    . n and the person at b = -v_i . n. The contact is attributed to the faster
    one, or to both if they approach equally fast. With coincident centers there
    is no n, and no attribution.
    """
    begins = recording.features.contact_begins
    sample, person = np.nonzero(begins)
    robot = recording.robot[sample]
    human = recording.humans[sample, person]
    d = human[:, X : Y + 1] - robot[:, X : Y + 1]
    distance = np.hypot(d[:, X], d[:, Y])
    n = d / np.where(distance > 0, distance, 1.0)[:, None]
    a = np.sum(robot[:, VX : VY + 1] * n, axis=1)
    b = -np.sum(human[:, VX : VY + 1] * n, axis=1)
    lead = a - b if to_robot else b - a
    together = (np.abs(lead) <= SPEED_RESOLUTION) & (a > 0)
    result = np.zeros(begins.shape, dtype=np.bool_)
    result[sample, person] = (lead > SPEED_RESOLUTION) | together
    return result


def _collisions(recording: Recording, *, to_robot: bool) -> tuple[float, Array]:
    events = charged(recording, to_robot=to_robot)
    features = recording.features
    # A contact keeps the attribution of its beginning.
    samples = np.arange(len(recording))[:, None]
    began = np.maximum.accumulate(
        np.where(features.contact_begins, samples, 0), axis=0
    )
    ongoing = features.contact & np.take_along_axis(events, began, axis=0)
    return float(np.count_nonzero(events)), ongoing.any(axis=1).astype(float)


for _alias, _who, _to_robot in (
    ("robot_on_person_collision", "robot", True),
    ("person_on_robot_collision", "person", False),
):
    register_metric(
        name=f"{_alias}s",
        unit="-",
        family="collisions",
        direction="lower",
        source=SEAN,
        aliases=[_alias],
        definition=f"""
            The number of contacts with people attributed to the {_who}.

            A contact begins where the gap to a person falls below 0.02 m, or is
            below it at the start. With n the unit vector from robot to person,
            a = v_r . n and b = -v_i . n at that sample, it is attributed to the
            robot if a > b, to the person if b > a, and to both if they are
            equal within 1e-6 m/s and positive. Series: 1 while such a contact
            lasts, else 0.
            """,
    )(partial(_collisions, to_robot=_to_robot))
