"""The recorded results of HuNavSim's evaluator, metric by metric."""

import dataclasses
import functools
import json
import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from hunav_drake.hunavsim.agents_yaml import BEHAVIOR_NAMES
from hunav_drake.hunavsim.differences import METRIC_REASONS
from hunav_drake.hunavsim.recording_json import parse_json
from hunav_drake.hunavsim.result_files import HUNAV_NAMES
from hunav_drake.systems.evaluation.compute import compute_metrics, evaluate
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.evaluation.recording import Recording
from tests.recorded import read_recorded, recorded_names

CASES = recorded_names("metrics") + recorded_names("metrics_hand")

# Names of the original of what must agree, of values and of series.
SAME = (
    "path_length",
    "cumulative_heading_changes",
    "avg_distance_to_closest_person",
    "minimum_distance_to_people",
    "intimate_space_intrusions",
    "personal_space_intrusions",
    "social_space_intrusions",
    "minimum_distance_to_target",
    "final_distance_to_target",
    "avg_robot_linear_speed",
    "avg_robot_angular_speed",
    "avg_pedestrian_velocity",
    "avg_closest_pedestrian_velocity",
)


class Case(NamedTuple):
    """A case of the original program."""

    recording: Recording
    # Its values, by the original's names, and its series.
    final: dict[str, Any]
    per_step: dict[str, Any]
    # The times of the samples since the first, in seconds.
    stamps: list[float]
    # The same for each behavior; None where nobody has it.
    by_behavior: dict[str, Any]


@functools.cache
def load_case(name: str) -> Case:
    """Reads a case of the evaluator from the recorded results."""
    text = read_recorded(name)
    expected = json.loads(text)["expected"]
    return Case(
        parse_json(text),
        expected["final"],
        expected["per_step"],
        expected["time_stamps"],
        {
            BEHAVIOR_NAMES[int(number)]: values
            for number, values in expected["by_behavior"].items()
        },
    )


def expected_here(name: str, final: dict[str, Any]) -> float:
    """Returns the original's value the way it is written here."""
    value = final[name]
    # The original has no word for "no value" but this.
    return math.nan if value == 10000 else float(value)


def assert_close(name: str, got: float, expected: float) -> None:
    assert got == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True), name


@pytest.fixture(params=CASES)
def case(request):
    return load_case(request.param)


def test_values_agree(case, request):
    values = compute_metrics(case.recording)
    for name in SAME:
        here = select_metrics([name])[0].name
        if name not in case.final:
            # The original failed at a step without people.
            assert "h19" in request.node.name
        elif (
            "h19" in request.node.name and here == "avg_dist_to_closest_person"
        ):
            # The original counts a step without people as a distance of 0.
            samples = len(case.recording)
            expected = case.final[name] * samples / (samples - 1)
            assert_close(name, values[here], expected)
        else:
            assert_close(name, values[here], expected_here(name, case.final))


def test_the_largest_distance_agrees_but_for_the_persons_radius(case):
    radius = case.recording.humans[..., 6]
    radii = np.unique(radius[~np.isnan(radius)])
    assert len(radii) == 1
    got = compute_metrics(case.recording, ["max_dist_to_people"]).iloc[0]
    expected = case.final["maximum_distance_to_people"]
    if got == 0:
        # They overlap all the time, and a gap is not negative.
        assert expected <= radii[0]
    else:
        assert_close("maximum", got + radii[0], expected)


def test_acceleration_agrees_but_for_the_divisor():
    case = load_case("metrics_hand/h13_sine_speed")
    samples = len(case.recording)
    got = compute_metrics(case.recording)["avg_robot_acceleration"]
    assert_close(
        "acceleration",
        got * (samples - 1) / samples,
        case.final["avg_acceleration"],
    )


def test_obstacle_forces_agree_but_for_the_number_of_points(case, request):
    recording = case.recording
    points = max(recording.nearest_walls.shape[2], 1)
    values = compute_metrics(recording, ["forces"])
    for name in ("obstacle_force_on_agents", "obstacle_force_on_robot"):
        if name not in case.final:
            assert "h19" in request.node.name
            continue
        expected = case.final[name]
        assert values[name] / points == pytest.approx(
            expected, rel=1e-6, abs=1e-6
        )


def test_forces_agree_where_they_are_asked_for_as_in_the_original(
    case, request
):
    if "robot_id_equals" in request.node.name:
        pytest.skip("there, a person with the robot's number is left out")
    recording = dataclasses.replace(case.recording, hunavsim_forces=True)
    values = compute_metrics(recording)
    for name in ("social_force_on_agents", "social_force_on_robot"):
        assert values[name] == pytest.approx(
            case.final[name], rel=1e-9, abs=1e-12
        ), request.node.name
    assert values["obstacle_force_on_robot"] == 0.0


def test_times_agree(case):
    times = case.recording.times - case.recording.times[0]
    assert times == pytest.approx(np.array(case.stamps), abs=2e-9)
    duration = compute_metrics(case.recording, ["duration"]).iloc[0]
    assert duration == pytest.approx(case.final["time_to_reach_goal"], abs=2e-9)


def test_series_agree(case, request):
    if "h19" in request.node.name:
        pytest.skip("the original's series lack the step without people")
    steps = evaluate(case.recording, SAME).steps()
    for name in SAME:
        here = select_metrics([name])[0].name
        if name in case.per_step and here in steps:
            expected = np.array(case.per_step[name], dtype=float)
            assert steps[here].to_numpy() == pytest.approx(
                expected, rel=1e-9, abs=1e-9
            ), name


def test_values_by_behavior_agree(case, request):
    if "h19" in request.node.name:
        pytest.skip("the original gives nothing where a person is missing")
    assert len(case.by_behavior) == 6
    for behavior, expected in case.by_behavior.items():
        if expected is None:
            assert behavior not in case.recording.behaviors
            continue
        values = compute_metrics(case.recording.only(behavior), SAME)
        for name in SAME:
            here = select_metrics([name])[0].name
            assert_close(
                name, values[here], expected_here(name, expected["final"])
            )


def test_every_metric_of_the_paper_is_the_same_or_different_for_a_reason():
    same = {select_metrics([name])[0].name for name in SAME}
    assert same | set(METRIC_REASONS) | {"completed"} == set(HUNAV_NAMES)
    assert not same & set(METRIC_REASONS)
    assert set(METRIC_REASONS) <= set(METRICS)


def test_what_differs_on_purpose_does_differ():
    """Prints, with `pytest -s`, the table of what differs, where, and why."""
    largest = dict.fromkeys(METRIC_REASONS, 0.0)
    where = dict.fromkeys(METRIC_REASONS, 0)
    for case in map(load_case, CASES):
        values = compute_metrics(case.recording, list(METRIC_REASONS))
        for name in METRIC_REASONS:
            original = case.final.get(HUNAV_NAMES[name], math.nan)
            if math.isnan(values[name]) and original in (0, 10000):
                continue
            difference = abs(values[name] - original)
            # What only one of the two has a value for differs, too.
            if not difference < 1e-9:
                where[name] += 1
                largest[name] = max(largest[name], difference)
    print(f"\n{'metric':32} {'cases':>5} {'largest':>9}  reason")
    for name, reason in METRIC_REASONS.items():
        print(f"{name:32} {where[name]:5} {largest[name]:9.3g}  {reason}")
    # The robot neither comes to rest nor near two walls in these cases.
    unseen = {name for name, count in where.items() if not count}
    assert unseen <= {"time_not_moving", "obstacle_force_on_robot"}


def test_completed_agrees_where_there_is_a_goal(case):
    values = compute_metrics(case.recording, ["goal"])
    if case.recording.goal is None:
        assert values.isna().all()
    else:
        assert values["completed"] == float(case.final["completed"])


def test_nothing_is_said_about_a_goal_that_is_not_there():
    case = load_case("metrics_hand/h17_no_goal")
    values = compute_metrics(case.recording)
    assert values[["min_dist_to_target", "final_dist_to_target"]].isna().all()
    assert values["min_dist_to_people"] > 0


@pytest.mark.parametrize(
    ("name", "robot", "person"),
    [
        ("h03_person_rams_back_of_standing_robot", 0, 1),
        ("h05_head_on_robot_faster", 1, 0),
        ("h15_one_group", None, None),
    ],
)
def test_collisions_are_charged_to_who_closes_in(name, robot, person):
    case = load_case(f"metrics_hand/{name}")
    values = compute_metrics(case.recording, ["collisions"])
    if robot is not None:
        assert values.tolist() == [robot, person]
    samples = (
        case.final["robot_on_person_collision"]
        + case.final["person_on_robot_collision"]
    )
    assert 1 <= values.sum() <= samples
