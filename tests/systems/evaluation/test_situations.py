"""Social situations of a recording: vocabulary.md, section 4."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from hunav_drake import FindSituations, LoadScenario, ReadRecording, RunTrial
from hunav_drake.systems.common.layout import (
    REACTIVE,
    REPLAYED,
    SILENT,
    Activity,
    Contact,
    Signal,
)
from hunav_drake.systems.evaluation import METRICS
from hunav_drake.systems.evaluation.compute import evaluate
from hunav_drake.systems.evaluation.groups import (
    groups_by_geometry,
    groups_by_signals,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situation_labels import (
    DOWN_PATHS,
    LABELS,
    PRIMARIES,
)
from hunav_drake.systems.evaluation.situation_values import situation_values
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.evaluation.trials import make, rows

PARTS = ("in_o_space", "join_group", "leave_group")


def one(distance=2.0, alpha=0.0, speed=1.0, robot_speed=0.6, **kwargs):
    """Returns the situations of a robot along x, and a person ahead of it.

    `alpha` is the angle of the person's course in degrees.
    """
    a = math.radians(alpha)
    person = rows(1, distance, 0, a, speed * math.cos(a), speed * math.sin(a))
    return FindSituations(
        make([0.0], rows(1, vx=robot_speed), [person], **kwargs)
    )


def held(situations):
    return {name for name in LABELS if situations.flags[name].any()}


def circle(n, radius, x=0.0, y=0.0, turn=0.3):
    """Returns the states (n, 7) of people who face the middle."""
    angle = turn + 2 * np.pi * np.arange(n) / n
    return rows(
        n, x + radius * np.cos(angle), y + radius * np.sin(angle), angle + np.pi
    )


def found_groups(*people):
    return groups_by_geometry(np.concatenate(people)[None])


def talking(people, path, goal=None, samples=121, step=0.1):
    """Returns a recording of standing people and of a robot along a path."""
    times = step * np.arange(samples)
    x, y = path(times)
    states = rows(
        samples, x, y, 0, np.gradient(x, times), np.gradient(y, times)
    )
    return make(
        times, states, list(people), goal=None if goal is None else (*goal, 0)
    )


@pytest.mark.parametrize("turn", [1, -1])
def test_33_angles_distance_speed_and_walls(turn):
    assert "cross_path" in held(one(alpha=75.1 * turn))
    assert "cross_path" not in held(one(alpha=74.9 * turn))
    assert "cross_path" not in held(one(alpha=105.1 * turn))
    assert "down_path" not in held(one(alpha=15.1 * turn))
    assert "down_path" in held(one(alpha=14.9 * turn))
    assert "down_path" in held(one(alpha=165.1 * turn))
    assert held(one(distance=2.41)) == {"empty"}
    assert held(one(speed=0.14)) == {"standing"}
    assert held(one(speed=0.15)) == {"down_path", "overtaking"}
    wall = Obstacles.from_shapes(
        [np.array([[1.0, -1.0], [1.0, 1.0]])], solid=[False]
    )
    assert held(one(obstacles=wall)) == {"empty"}
    assert held(one(alpha=45)) == {"other"}


def test_33_kinds_of_paths():
    assert held(one(alpha=180)) == {"down_path", "passing"}
    assert held(one(speed=0.49)) == {"down_path", "overtaking"}
    assert held(one(speed=0.51)) == {"down_path", "following"}
    assert held(one(speed=0.69)) == {"down_path", "following"}
    assert held(one(speed=0.71)) == {"down_path"}
    assert held(one(distance=-2.0, speed=0.71)) == {"down_path", "overtaken"}
    assert held(one(distance=-2.0, speed=0.6)) == {"down_path"}
    # A robot that drives backwards has the course of its velocity; one that
    # stands, its heading.
    assert "passing" in held(one(distance=-2.0, robot_speed=-0.6))
    assert "overtaking" not in held(one(robot_speed=-0.04))
    assert "down_path" in held(one(robot_speed=-0.04))


@pytest.mark.parametrize("n", range(2, 9))
@pytest.mark.parametrize("radius", ["open", "formation"])
def test_34_circles_are_found(n, radius):
    r = 0.7 + 0.12 * (n - 1) if radius == "open" else 0.5 + 0.2 * (n - 1)
    found = found_groups(circle(n, r, 3.0, -2.0))
    np.testing.assert_allclose(found.center, [[3.0, -2.0]], atol=1e-9)
    np.testing.assert_allclose(found.radius, [r], atol=1e-9)
    assert found.members.all()


def test_34_queues_benches_and_walkers_are_no_groups():
    for n in range(2, 7):
        queue = rows(n, -0.9 * np.arange(n), 1.0, 0.0)
        assert len(found_groups(queue).sample) == 0
    bench = rows(4, 0.6 * np.arange(4), 0.0, -1.57)
    assert len(found_groups(bench).sample) == 0
    walkers = rows(2, 0.0, [0.0, 1.0], [0.5, -0.5], 1.0)
    assert len(found_groups(walkers).sample) == 0


def test_34_two_circles_are_two_groups():
    found = found_groups(circle(3, 0.94), circle(4, 1.06, 4.0))
    np.testing.assert_allclose(
        sorted(found.center.tolist()), [[0, 0], [4, 0]], atol=1e-9
    )
    assert found.members.sum(axis=1).tolist() in ([3, 4], [4, 3])


def test_34_who_stands_beside_a_circle_is_no_member():
    watcher = rows(1, 2.3, 0.0, np.pi)
    found = found_groups(circle(4, 1.06), watcher)
    np.testing.assert_allclose(found.center, [[0, 0]], atol=1e-9)
    assert found.members.tolist() == [[True] * 4 + [False]]


def test_34_noise():
    """Standard deviations of 0.1 m and 0.3 rad; seeded."""
    rng = np.random.default_rng(1)
    hits, count = 0, 0
    for n in range(2, 9):
        for r in (0.7 + 0.12 * (n - 1), 0.5 + 0.2 * (n - 1)):
            people = np.array([circle(n, r)] * 100)
            people[..., :2] += rng.normal(0, 0.1, (100, n, 2))
            people[..., 2] += rng.normal(0, 0.3, (100, n))
            found = groups_by_geometry(people)
            hits += len(np.unique(found.sample))
            count += 100
    assert hits / count >= 0.99


def brute_force(recording):
    """Returns the shares of samples with few labels, written once more."""
    counts = dict.fromkeys(("empty", "down_path", "cross_path"), 0)
    for robot, people in zip(recording.robot, recording.humans, strict=True):
        x, y, yaw, vx, vy = robot[:5].tolist()
        course = math.atan2(vy, vx) if math.hypot(vx, vy) >= 0.05 else yaw
        near = [
            p for p in people.tolist() if math.hypot(p[0] - x, p[1] - y) <= 2.4
        ]
        turns = [
            abs(
                math.degrees(
                    math.remainder(math.atan2(p[4], p[3]) - course, 2 * math.pi)
                )
            )
            for p in near
            if math.hypot(p[3], p[4]) >= 0.15
        ]
        counts["empty"] += not near
        counts["down_path"] += any(a <= 15 or a >= 165 for a in turns)
        counts["cross_path"] += any(75 <= a <= 105 for a in turns)
    return {name: it / len(recording) for name, it in counts.items()}


DATA = Path(__file__).resolve().parents[2] / "data"

# The shares of the specification, and those of today, whose people walk
# otherwise.
TOLD = {
    "passing": {"empty": 0.736, "down_path": 0.264, "cross_path": 0.0},
    "crossing": {"empty": 0.458, "down_path": 0.0, "cross_path": 0.290},
}
TODAY = {
    "passing": {"empty": 0.731, "down_path": 0.194, "cross_path": 0.0},
    "crossing": {"empty": 0.144, "down_path": 0.0, "cross_path": 0.188},
}


@pytest.mark.parametrize("name", TOLD)
def test_35_shares_of_the_trials_of_the_specification(name):
    """Of the recordings from which the specification told them."""
    recording = ReadRecording(DATA / f"situations_{name}.csv.gz")
    shares = FindSituations(recording).shares()["share"]
    for label, share in TOLD[name].items():
        assert shares[label] == pytest.approx(share, abs=0.02), label
    neither = shares["standing"] + shares["other"]
    expected = 1 - sum(TOLD[name].values())
    assert neither == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize("name", TODAY)
def test_35_shares_of_the_same_trials_today(name):
    """With a second computation, which shares no code with the first."""
    scenario = LoadScenario(filename=name, overrides=["planner.type=pursuit"])
    recording = RunTrial(scenario, 0).recording
    shares = FindSituations(recording).shares()["share"]
    told = brute_force(recording)
    for label, share in TODAY[name].items():
        assert shares[label] == pytest.approx(share, abs=0.02)
        # These count samples, which are 0.1 s apart.
        assert shares[label] == pytest.approx(told[label], abs=0.006)


def gap_of_three():
    """A circle of three about the origin with a gap towards the robot."""
    angle = np.pi / 2 * np.array([1, 2, 3])
    return rows(3, 0.94 * np.cos(angle), 0.94 * np.sin(angle), angle + np.pi)


def test_36_join_and_leave_group():
    goal = (0.94, 0.0)

    def towards(t):
        return np.maximum(0.94 + 8.0 - 0.8 * t, 0.94), 0 * t

    recording = talking(gap_of_three(), towards, goal)
    found = FindSituations(recording)
    distance = recording.features.goal_distance
    nears = np.append(False, np.diff(distance) < 0)
    expected = (distance <= 2.4) & nears
    # Until 1 s after it has come.
    last = np.flatnonzero(expected)[-1]
    expected[last : last + 10] = True
    np.testing.assert_array_equal(found.flags["join_group"], expected)
    assert not found.flags["leave_group"].any()

    def away(t):
        return np.minimum(0.94 + 0.8 * t, 8.94), 0 * t

    left = FindSituations(talking(gap_of_three(), away, (8.94, 0.0)))
    distance = left.recording.robot[:, 0] - 0.94
    expected = (distance <= 2.4) & (distance > 0)
    np.testing.assert_array_equal(left.flags["leave_group"], expected)
    assert not left.flags["join_group"].any()


def test_in_o_space():
    people = circle(4, 1.06)
    for x, holds in ((0.70, True), (0.72, False)):
        found = FindSituations(make([0.0], rows(1, x), list(people[:, None])))
        assert found.flags["in_o_space"].all() == holds


@pytest.mark.parametrize("name", ["passing", "crossing", "three_robots"])
def test_37_metrics_on_the_samples_of_labels(name):
    scenario = LoadScenario(
        filename=name,
        overrides=["evaluator.situations=true", "simulation.duration=8"],
    )
    metrics = RunTrial(scenario, 0).metrics
    robots = ["red.", "green.", "blue."] if name == "three_robots" else [""]
    names = {
        str(it).rpartition("min_dist_to_people")[0]
        for it in metrics.index
        if str(it).endswith("min_dist_to_people")
    }
    assert len(names) == len(robots)
    for robot in names:
        least = [
            metrics.get(f"{robot}min_dist_to_people[{label}]", np.nan)
            for label in PRIMARIES
        ]
        assert np.nanmin(least) == metrics[f"{robot}min_dist_to_people"]
        shares = [
            metrics.get(f"{robot}primary_share[{label}]", 0.0)
            for label in PRIMARIES
        ]
        assert sum(shares) == pytest.approx(1, abs=1e-12)


def test_37_sums_and_counts_add_up():
    """Over labels that exclude each other and are all there is."""
    run = RunTrial(LoadScenario(filename="crossing"), 0)
    values = situation_values(run.recording, evaluate(run.recording))
    situations = FindSituations(run.recording)
    labels = [it for it in LABELS if f"path_length[{it}]" in values]
    assert sum(situations.flags[it].astype(int) for it in labels).max() == 1
    for name in ("path_length", "robot_on_person_collisions", "social_work"):
        parts = [values[f"{name}[{label}]"][0] for label in labels]
        assert sum(parts) == pytest.approx(run.metrics[name], abs=1e-9), name


def test_results_without_the_option_are_as_they_were():
    scenario = LoadScenario(
        filename="passing", overrides=["simulation.duration=1"]
    )
    assert not any(
        "[" in str(name) for name in RunTrial(scenario).metrics.index
    )


def wild(seed=0, samples=80, n=7):
    """Returns a recording in which everything happens, and signals."""
    rng = np.random.default_rng(seed)
    times = 0.1 * np.arange(samples)
    states = np.zeros((samples, n + 1, 7))
    states[..., :2] = np.cumsum(
        rng.normal(0, 0.1, (samples, n + 1, 2)), axis=0
    ) + rng.uniform(-2, 2, (n + 1, 2))
    states[..., 3:5] = np.gradient(states[..., :2], times, axis=0)
    states[..., 3:5] *= (rng.uniform(size=n + 1) < 0.5)[:, None]
    states[..., 2] = rng.uniform(-3, 3, n + 1)
    states[..., 6] = 0.3
    states[:, 1:4] = circle(3, 0.94)
    states[20:30, 5] = np.nan
    return make(
        times,
        states[:, 0],
        list(states[:, 1:].transpose(1, 0, 2)),
        goal=(0.94, 0.3, 0.0),
        obstacles=Obstacles.from_shapes(
            [np.array([[1.0, -3.0], [1.5, 3.0]])], solid=[False]
        ),
    )


def moved(recording, angle, mirror):
    """Returns the recording in a world that is turned, and then mirrored."""
    c, s = math.cos(angle), math.sin(angle)
    m = np.diag([1.0, -1.0 if mirror else 1.0]) @ np.array([[c, -s], [s, c]])
    sign = -1.0 if mirror else 1.0

    def of(states):
        result = states.copy()
        result[..., :2] = states[..., :2] @ m.T
        result[..., 3:5] = states[..., 3:5] @ m.T
        result[..., 2] = sign * (states[..., 2] + angle)
        return result

    goal = m @ recording.goal[:2]
    walls = [m @ np.array(p) for p in ([1.0, -3.0], [1.5, 3.0])]
    return dataclasses.replace(
        recording,
        robot=of(recording.robot),
        humans=of(recording.humans),
        goal=(*goal, 0.0),
        obstacles=Obstacles.from_shapes([np.array(walls)], solid=[False]),
    )


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("mirror", [False, True])
def test_turned_and_mirrored_worlds_have_the_same_labels(seed, mirror):
    before = FindSituations(wild(seed))
    after = FindSituations(moved(wild(seed), 1.1, mirror))
    for name in LABELS:
        np.testing.assert_array_equal(before.people[name], after.people[name])
    assert before.primary.tolist() == after.primary.tolist()
    sides = before.episodes()["side"]
    if mirror:
        sides = sides.replace({"left": "right", "right": "left"})
    assert sides.tolist() == after.episodes()["side"].tolist()


def test_the_wild_recordings_have_many_labels():
    assert (
        len(set().union(*(held(FindSituations(wild(i))) for i in range(6))))
        >= 9
    )


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_people_does_not_matter(seed):
    recording = wild(seed)
    order = np.random.default_rng(seed).permutation(recording.num_humans)
    other = dataclasses.replace(
        recording,
        humans=recording.humans[:, order],
        human_names=tuple(recording.human_names[i] for i in order),
    )
    before, after = FindSituations(recording), FindSituations(other)
    for name in LABELS:
        np.testing.assert_array_equal(
            before.people[name][:, order], after.people[name]
        )


def signalled(recording, **columns):
    """Returns a recording with signals; each is (person, value)."""
    shape = (len(recording), recording.num_humans, len(Signal))
    signals = np.zeros(shape)
    signals[..., [Signal.TO, Signal.GAZE, Signal.HOST]] = -1
    for name, told in columns.items():
        for person, value in told:
            signals[:, person, Signal[name]] = value
    return dataclasses.replace(recording, social_signals=signals)


def two(distance=1.0, yaw=np.pi, samples=11):
    """Returns a robot that stands, and two people ahead of it."""
    return make(
        np.arange(samples) / 10,
        rows(samples),
        [rows(samples, distance, 0, yaw), rows(samples, 2.0, 5.0)],
    )


def test_signals_tell_queues():
    queue = {"ACTIVITY": [(0, Activity.QUEUE)]}
    assert held(FindSituations(signalled(two(1.19), **queue))) == {"at_queue"}
    assert held(FindSituations(signalled(two(1.21), **queue))) == {"standing"}


def test_signals_tell_who_blocks_and_accompanies():
    block = [(0, Activity.BLOCK)]
    for gaze, yaw, holds in (
        (-1, np.pi, True),
        (-1, np.pi - 0.3, False),
        (2, 0.0, True),
        (3, np.pi, False),
        (1, np.pi, False),
    ):
        recording = signalled(two(yaw=yaw), ACTIVITY=block, GAZE=[(0, gaze)])
        assert FindSituations(recording).flags["blocked"].all() == holds
    at = [("GAZE", -2), ("GAZE_X", 0.0), ("GAZE_Y", 0.1)]
    told = {name: [(0, value)] for name, value in at}
    recording = signalled(two(yaw=0.0), ACTIVITY=block, **told)
    assert held(FindSituations(recording)) == {"blocked"}
    beside = {"ACTIVITY": [(0, Activity.ACCOMPANY)]}
    assert held(FindSituations(signalled(two(), **beside))) == {"accompanied"}
    other = FindSituations(signalled(two(), **beside, GAZE=[(0, 3)]))
    assert held(other) == {"standing"}


def test_signals_tell_circles():
    """Those who are still on their way are no members; nor are bystanders."""
    people = [
        *circle(3, 0.94, 1.0),
        rows(1, 3.0, vx=0.5)[0],
        rows(1, 1, 1.5)[0],
    ]
    recording = make([0.0], rows(1, 1.0), [it[None] for it in people])
    talk = [(i, Activity.CONVERSATION) for i in range(4)]
    shown = signalled(
        recording,
        ACTIVITY=talk,
        HOST=[(i, 1) for i in (0, 2, 3)],
        CENTER_X=[(1, 1.0)],
    )
    found = FindSituations(shown)
    assert found.people["in_o_space"].tolist() == [[True] * 3 + [False] * 2]
    # With signals, geometry does not count.
    assert not FindSituations(signalled(recording)).flags["in_o_space"].any()
    # The host may be a robot, whose signals are not recorded.
    by_robot = signalled(
        recording, ACTIVITY=talk, HOST=[(i, 5) for i in range(4)]
    )
    assert FindSituations(by_robot).flags["in_o_space"].all()


def test_doors():
    door = [[0.5, 0.0]]
    assert FindSituations(two(1.9), doors=door).flags["at_door"].all()
    assert not FindSituations(two(2.1), doors=door).flags["at_door"].any()
    assert not FindSituations(two(1.9)).flags["at_door"].any()
    known = dataclasses.replace(two(1.9), doors=door)
    assert FindSituations(known).flags["at_door"].all()
    assert not FindSituations(known, doors=()).flags["at_door"].any()
    with pytest.raises(
        ValueError, match=r"doors: must have the shape \(k, 2\)"
    ):
        FindSituations(two(), doors=[1.0, 2.0, 3.0])


def test_the_first_label_is_the_primary_one():
    queue = {"ACTIVITY": [(0, Activity.QUEUE)]}
    found = FindSituations(signalled(two(), **queue), doors=[[0.5, 0.0]])
    assert held(found) == {"at_queue", "at_door"}
    assert set(found.primary) == {"at_door"}
    assert set(DOWN_PATHS).isdisjoint(PRIMARIES)


def test_absent_people_and_empty_places():
    gone = make([0.0, 0.1], rows(2), [np.full((2, 7), np.nan)])
    nobody = make([0.0, 0.1], rows(2))
    for recording in (gone, nobody):
        found = FindSituations(recording)
        assert held(found) == {"empty"}
        assert found.shares()["primary"].sum() == 1
        assert situation_values(recording, evaluate(recording))


def test_one_sample():
    found = one(alpha=180)
    assert found.primary.tolist() == ["down_path"]
    assert found.shares().loc["passing", "share"] == 1
    assert found.episodes().empty
    assert list(found.episodes().columns)[:3] == ["label", "begin", "end"]


def test_episodes_close_short_gaps_and_drop_short_ones():
    """Somebody is near from 1 to 2, 2.9 to 4, 5 to 6 and 8.0 to 8.4 s."""
    times = np.arange(0, 10.01, 0.1)
    near = np.zeros(len(times), dtype=bool)
    for begin, end in ((10, 20), (29, 40), (50, 60), (80, 84)):
        near[begin:end] = True
    person = rows(len(times), np.where(near, 2.0, 5.0))
    found = FindSituations(make(times, rows(len(times)), [person]))
    told = found.episodes()
    told = told[told["label"] == "standing"]
    np.testing.assert_allclose(
        told[["begin", "end"]], [[0.95, 3.95], [4.95, 5.95]], atol=1e-9
    )
    assert found.shares().loc["standing", "episodes"] == 2
    assert found.shares().loc["standing", "episode_time"] == pytest.approx(4)
    np.testing.assert_allclose(told["least_gap"], 1.3)


def test_an_episode_tells_what_happened():
    """The robot slows to half its speed while somebody passes on its left."""
    times = np.arange(0, 20.01, 0.1)
    v = np.where((times > 8) & (times < 10), 0.5, 1.0)
    x = np.cumsum(v) * 0.1
    robot = rows(len(times), x, vx=v)
    person = rows(len(times), 18 - 1.0 * times, 1.0, np.pi, -1.0)
    found = FindSituations(make(times, robot, [person]))
    told = found.episodes().set_index("label").loc["passing"]
    assert told["people"] == "human_1"
    assert told["side"] == "left"
    assert told["slowed"] == "robot"
    assert told["least_gap"] == pytest.approx(0.3, abs=0.01)
    inside = (found.edges[:-1] >= told["begin"]) & (
        found.edges[1:] <= told["end"]
    )
    slow = 0.1 * np.count_nonzero(inside & (v < 1))
    assert told["delay"] == pytest.approx(slow / 2, abs=0.06)
    # Without a time in which it moves alone, nobody knows.
    still = make(times, rows(len(times)), [person])
    assert FindSituations(still).episodes()["delay"].isna().all()


def test_several_robots():
    first = two(1.0)
    second = dataclasses.replace(
        two(1.0), robot=rows(11, 9.0), robot_name="b", end_time=0.5
    )
    both = dataclasses.replace(
        signalled(first, ACTIVITY=[(0, Activity.BLOCK)], GAZE=[(0, 2)]),
        robot_name="a",
        others=(second,),
    )
    assert held(FindSituations(both, robot="a")) == {"blocked"}
    found = FindSituations(both, robot="b")
    assert held(found) == {"empty"}
    assert len(found.primary) == 6
    with pytest.raises(ValueError, match="robot: must be one of 'a', 'b', got"):
        FindSituations(both)
    values = situation_values(both, evaluate(both))
    assert values["a.min_dist_to_people[blocked]"][0] == pytest.approx(0.3)
    assert values["b.time_share[empty]"][0] == 1
    # A code names one robot among all.
    turned = signalled(both, ACTIVITY=[(0, Activity.BLOCK)], GAZE=[(0, 3)])
    assert held(FindSituations(turned, robot="a")) == {"standing"}


def test_every_metric_with_a_series_has_values_by_label():
    """But those of users who do not tell how the value follows from it."""
    recording = RunTrial(LoadScenario(filename="crossing"), 0).recording
    found = evaluate(recording)
    values = situation_values(recording, found)
    assert "cross_path" in FindSituations(recording).primary
    for name in found.series:
        assert f"{name}[cross_path]" in values, name
    for name, (_, facts) in values.items():
        base = name.partition("[")[0]
        if base in METRICS:
            assert facts["units"] == METRICS[base].unit


def test_a_recording_of_another_program(tmp_path):
    lines = ["time,agent,x,y"]
    for t in np.arange(50) / 10:
        lines += [f"{t},robot,{0.8 * t},0", f"{t},p,{6 - 1.2 * t},0.6"]
    path = tmp_path / "crowd.csv"
    path.write_text("\n".join(lines))
    assert "passing" in held(FindSituations(ReadRecording(path)))


TALK = """
places: [{name: corner, pose: [2, 1, 0]}]
humans:
  - pose: [2, -0.5, 0]
    goals: [[6, 0]]
    behavior: |
      <root BTCPP_format="4" main_tree_to_execute="Meet">
        <BehaviorTree ID="Meet">
          <ReactiveFallback>
            <RunOnce>
              <ConversationFormation goal_id="corner"
                non_main_agent_ids="2, 3" conversation_duration="8"/>
            </RunOnce>
            <SubTree ID="RegularNavTree"/>
          </ReactiveFallback>
        </BehaviorTree>
      </root>
  - {pose: [4, 2, 3.14], goals: [[-4, 2]]}
  - {pose: [2, 3, -1.57], goals: [[2, -4]]}
robot: {start: [-3, 1, 0], goal: [1.2, 1.2, 0]}
planner: {type: pursuit}
simulation: {duration: 9}
"""


def test_a_talk_is_the_same_by_signals_and_by_geometry():
    """While all are in place; o is where they were told to meet."""
    recording = RunTrial(LoadScenario(data=TALK)).recording
    humans, signals = recording.humans, recording.social_signals
    shown = groups_by_signals(humans, signals)
    seen = groups_by_geometry(humans)
    np.testing.assert_allclose(shown.center, [[2, 1]] * len(shown.center))
    both = np.intersect1d(
        shown.sample[shown.members.all(axis=1)],
        seen.sample[seen.members.all(axis=1)],
    )
    assert len(both) > 30
    centers = seen.center[np.isin(seen.sample, both)]
    np.testing.assert_allclose(centers, [[2, 1]] * len(both), atol=0.2)
    for told in (
        recording,
        dataclasses.replace(recording, social_signals=None),
    ):
        found = FindSituations(told)
        assert found.flags["join_group"].sum() > 10


TREE = """
      <root BTCPP_format="4" main_tree_to_execute="It">
        <BehaviorTree ID="It">{}</BehaviorTree>
      </root>
"""


@pytest.mark.slow
def test_who_accompanies_a_robot_is_told():
    scenario = LoadScenario(
        data="humans:\n  - pose: [-3, 1.5, 0]\n    behavior: |"
        + TREE.format("<AccompanyRobot/>")
        + "robot: {start: [-4, 0, 0], goal: [4, 0, 0]}\n"
        + "planner: {type: pursuit}\nsimulation: {duration: 8}"
    )
    found = FindSituations(RunTrial(scenario).recording)
    assert found.shares().loc["accompanied", "primary"] > 0.9
    assert found.flags["down_path"].any()


@pytest.mark.slow
def test_an_open_circle_is_told_from_when_two_stand_in_it():
    one = TREE.format("<Converse/>")
    two = TREE.format('<JoinConversation distance="9"/>')
    scenario = LoadScenario(
        data=f"humans:\n  - pose: [0, 0, 0]\n    behavior: |{one}"
        f"  - pose: [4, 0, 3.14]\n    behavior: |{two}"
        "robot: {start: [-2, -3, 0], goal: [4, -3, 0]}\n"
        "planner: {type: pursuit}\nsimulation: {duration: 8}"
    )
    recording = RunTrial(scenario).recording
    shown = groups_by_signals(recording.humans, recording.social_signals)
    assert len(shown.sample) > 20
    np.testing.assert_allclose(shown.radius, 0.82, atol=0.4)
    np.testing.assert_allclose(shown.radius[-1], 0.82, atol=0.12)


def test_people_of_one_behavior_keep_whom_they_are_with():
    """Row codes in signals are those of the people who are left."""
    shown = np.tile(SILENT, (1, 4, 1))
    # Those in rows 0, 2 and 3 talk; the host is in row 2. One looks at row 1.
    for i in (0, 2, 3):
        shown[0, i, Signal.ACTIVITY] = Activity.CONVERSATION
        shown[0, i, Signal.HOST] = 2
    shown[0, 2, Signal.PARTNER_1 : Signal.PARTNER_3] = 0, 3
    shown[0, 0, Signal.GAZE], shown[0, 3, Signal.GAZE] = 1, 4
    humans = np.zeros((1, 4, 7))
    humans[0, :, 0] = range(4)
    humans[0, :, 6] = 0.3
    whole = Recording(
        times=[0.0],
        robot=np.array([[9.0, 0, 0, 0, 0, 0, 0.3]]),
        humans=humans,
        behaviors=("a", "b", "a", "a"),
        social_signals=shown,
    )
    part = whole.only("a").social_signals[0]
    assert part[:, Signal.HOST].tolist() == [1, 1, 1]
    assert part[1, Signal.PARTNER_1 : Signal.PARTNER_3].tolist() == [0, 2]
    # Who is left out is nobody; the robot comes after the three.
    assert part[:, Signal.GAZE].tolist() == [-1, -1, 3]
    assert whole.social_signals[0, 0, Signal.GAZE] == 1


def test_values_of_a_label_that_always_holds_are_those_of_the_trial():
    """Also where several people touch, arrive, or feel a force at once."""
    samples = 41
    times = 0.1 * np.arange(samples)
    robot = rows(samples, times, vx=1.0)
    people = [rows(samples, 2.0, 0.2), rows(samples, 2.2, -0.2)]
    contacts = np.zeros((samples, 2, len(Contact)))
    # A peak between two samples, and a smaller force at the next ones.
    contacts[14:18, 0, Contact.FORCE_X] = -40.0
    contacts[14:, 0, Contact.PEAK_FORCE] = 900.0
    contacts[14:, 0, Contact.IMPULSE] = 12.0
    replay = np.zeros((samples, 2, 3))
    replay[..., 0], replay[20:, 1, 0] = REPLAYED, -1.0
    replay[5:, 0, 0] = REACTIVE
    replay[..., 1:] = times[:, None, None] * np.array([1.0, 0.5])
    run = make(
        times,
        robot,
        people,
        goal=(4.5, 0, 0),
        contacts=contacts,
        contact_forces_known=True,
        replay=replay,
    )
    found = evaluate(run)
    values = situation_values(run, found)
    assert values["time_share[standing]"][0] == 1.0
    assert found.values["robot_on_person_collisions"] == 2
    assert found.values["max_contact_force"] == 900.0
    names = [it.partition("[")[0] for it in values if it.endswith("[standing]")]
    assert {"replay_ade", "reactive_share", "hand_overs"} <= {*names}
    for name in names:
        if name in found.values:
            value = values[f"{name}[standing]"][0]
            told = found.values[name]
            assert value == pytest.approx(told, nan_ok=True), name


def test_without_people_nobody_is_touched_in_any_situation():
    run = make(0.1 * np.arange(5), rows(5, vx=1.0), goal=(4.5, 0, 0))
    values = situation_values(run, evaluate(run))
    assert values["time_share[empty]"][0] == 1.0
    for name in ("robot_on_person_collisions", "person_on_robot_collisions"):
        assert values[f"{name}[empty]"][0] == 0.0
