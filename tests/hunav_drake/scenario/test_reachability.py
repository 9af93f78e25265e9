"""Goals that cannot be reached are told, with the reason and the remedy."""

import dataclasses
import math
import time

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from hunav_drake import CheckScenario, LoadScenario, ScenarioError
from hunav_drake.scenario.reachability import FreeSpace, check_ways
from hunav_drake.systems.world.shapes import Box, World

# Two rooms of 6 m x 6 m, with a door of a width in the wall between.
ROOMS = """
world:
  walls:
    - {{type: box, name: south, center: [6, -0.1], size: [12.4, 0.2]}}
    - {{type: box, name: north, center: [6, 6.1], size: [12.4, 0.2]}}
    - {{type: box, name: west, center: [-0.1, 3], size: [0.2, 6.4]}}
    - {{type: box, name: east, center: [12.1, 3], size: [0.2, 6.4]}}
    - {{type: box, name: below, center: [6, {below}], size: [0.2, {size}]}}
    - {{type: box, name: above, center: [6, {above}], size: [0.2, {size}]}}
robot:
  radius: 0.3
  start: [2, 3, 0]
  goal: {goal}
humans:
  - {{name: ana, pose: [3, 5, 0], goals: {goals}}}
"""


def rooms(door=1.0, goal="[10, 3, 0]", goals="[[4, 1]]"):
    size = 3 - door / 2
    below, above = size / 2, 6 - size / 2
    return ROOMS.format(
        below=below, above=above, size=size, goal=goal, goals=goals
    )


def faults(data, **options):
    with pytest.raises(ScenarioError) as caught:
        LoadScenario(data=data, ways=True, **options)
    return [str(fault) for fault in caught.value.faults]


@pytest.mark.parametrize("door", [0.62, 0.7, 1.0, 2.0])
def test_a_door_wider_than_the_robot_is_a_way(door):
    assert LoadScenario(data=rooms(door), ways=True).robot.radius == 0.3


@pytest.mark.parametrize("door", [0.1, 0.4, 0.59])
def test_a_door_too_narrow_is_named_with_its_width_and_place(door):
    (fault,) = faults(rooms(door))
    assert fault.startswith("data:13: robot.goal: cannot be reached from")
    assert f"a door of {door:.2f} m between" in fault
    assert "('below')" in fault
    assert "('above')" in fault
    assert "at (6.00, 3.00)" in fault
    assert "a body 0.60 m wide" in fault


def test_what_the_remedy_says_is_enough():
    (fault,) = faults(rooms(0.5))
    radius = fault.split("a radius below ")[1].split()[0]
    overrides = {"robot.radius": str(float(radius) - 0.001)}
    LoadScenario(data=rooms(0.5), overrides=overrides, ways=True)


def test_a_wall_across_the_way_is_named():
    (fault,) = faults(rooms(0.0))
    assert "('below') stands between, without a way" in fault or (
        "('above') stands between, without a way" in fault
    )
    assert "leave a gap of more than 0.60 m" in fault


def test_a_goal_outside_of_the_building_is_told_with_a_place_inside():
    (fault,) = faults(rooms(goal="[14, 3, 0]"))
    assert "it is outside of the building" in fault
    assert "the nearest place inside is (11.70, 3.00)" in fault
    LoadScenario(data=rooms(goal="[11.70, 3, 0]"), ways=True)


def test_people_need_ways_too_but_turn_sideways_in_doors():
    person = {"humans[0].radius": "0.4"}
    goals = "[[4, 1], [9, 3]]"
    LoadScenario(data=rooms(0.7, goals=goals), overrides=person, ways=True)
    robot = {**person, "robot.radius": "0.2"}
    (fault,) = faults(rooms(0.55, goals=goals), overrides=robot)
    assert "humans[0] ('ana').goals[1]: cannot be reached from the" in fault
    assert "a door of 0.55 m" in fault


def test_near_the_goal_is_near_enough():
    """A goal in a narrow corner counts as reached within its tolerance."""
    close = rooms(goal="[11.69, 0.32, 0]")
    LoadScenario(data=close, ways=True)
    data = rooms(door=0.0, goal="[5.5, 3, 0]", goals="[[6.3, 3]]")
    wide = {"humans[0].goal_radius": "0.8"}
    LoadScenario(data=data, overrides=wide, ways=True)


def test_python_is_told_as_well_but_trials_may_run():
    scenario = LoadScenario(data=rooms(0.4))
    with pytest.raises(ScenarioError, match=r"a door of 0\.40 m"):
        CheckScenario(scenario)
    assert CheckScenario(scenario, ways=False) == scenario


@pytest.mark.parametrize(
    ("override", "place"),
    [
        ("robot.start=[2, 3, 90]", "--set robot.start=[2, 3, 90]: robot.start"),
        ("humans[0].pose=[3, 5, -180]", "humans[0] ('ana').pose[2]"),
    ],
)
def test_an_angle_in_degrees_is_a_warning(override, place):
    with pytest.warns(UserWarning, match="more than a whole turn") as caught:
        LoadScenario(data=rooms(), overrides=[override])
    text = str(caught[0].message)
    assert place in text
    degrees = float(override.rstrip("]").split()[-1])
    assert f"write {math.radians(degrees):.4f}" in text


def test_angles_within_a_turn_are_no_warning(recwarn):
    LoadScenario(data=rooms(), overrides=["robot.start=[2, 3, 6.28]"])
    assert not recwarn


def test_a_goal_in_an_outer_wall_is_to_be_moved_inside():
    """Also where the other side of the wall is nearer."""
    with pytest.raises(ScenarioError) as caught:
        LoadScenario(data=rooms(goal="[12.15, 3, 0]"))
    (fault,) = caught.value.faults
    assert "('east'); move it 0.45 m along (-1.00, 0.00)" in fault.message


def test_shipped_scenarios_have_ways_found_fast():
    names = ["warehouse", "office", "hospital"]
    scenarios = [LoadScenario(name) for name in names]
    started = time.process_time()
    for scenario in scenarios:
        assert not list(check_ways(scenario))
    assert time.process_time() - started < 0.5 * len(names)


@settings(max_examples=25)
@given(
    door=st.floats(0.1, 2.0),
    radius=st.floats(0.05, 1.0),
    turn=st.floats(0, 2 * math.pi),
)
def test_a_gap_is_as_wide_as_it_is_built_in_any_direction(door, radius, turn):
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s], [s, c]])

    def box(x, y, width, height):
        # Long enough that the way around them is no way.
        x, y = rotation @ [x, y]
        return Box(center=(x, y), size=(width, height), yaw=turn)

    length = 40
    y = (door + length) / 2
    walls = [box(0, y, 0.2, length), box(0, -y, 0.2, length)]
    walls += [box(0, 2 * y, 99, 0.2), box(0, -2 * y, 99, 0.2)]
    walls += [box(-49, 0, 0.2, 99), box(49, 0, 0.2, 99)]
    space = FreeSpace(World(walls=walls).fixtures())
    start, goal = (tuple(rotation @ [x, 0.0]) for x in (-3.0, 3.0))
    reached = space.joins(start, goal, radius, 0.1)
    if abs(2 * radius - door) > 0.02:
        assert reached == (2 * radius < door)
    if not reached:
        assert space.gap(start, goal, radius).width == pytest.approx(
            door, abs=0.02
        )


def test_a_world_without_walls_is_all_one_room():
    scenario = LoadScenario(data="robot: {goal: [90, 0, 0]}")
    free = dataclasses.replace(scenario, world=World())
    assert not list(check_ways(free))
