"""Generated scenarios: ways, seeds, difficulty, and what is refused."""

import itertools

import numpy as np
import pytest
import shapely

from hunav_drake import CheckScenario, GenerateScenario, SaveScenario
from hunav_drake.scenario import LoadScenario
from hunav_drake.scenario.generate.buildings import walls_around
from hunav_drake.scenario.generate.kind import draw_scenario, make_kind
from hunav_drake.scenario.randomness import same_for_all_seeds
from hunav_drake.systems.world.shapes import Disc

KINDS = ["field", "corridors", "rooms", "office"]


def solids(scenario):
    """Returns the footprints of a world, made here from its outlines."""
    return shapely.union_all(
        [
            shapely.Polygon(outline)
            for fixture in scenario.world.fixtures()
            for outline in fixture.footprints
        ]
    )


def clearance(scenario):
    """Returns half the width of the widest way of the robot, in meters."""
    walls = solids(scenario)
    start, goal = (
        shapely.Point(it[:2])
        for it in (scenario.robot.start, scenario.robot.goal)
    )
    low, high = 0.0, 1.5
    while high - low > 0.01:
        middle = (low + high) / 2
        hall = walls.envelope.difference(walls.buffer(middle))
        joined = any(
            part.distance(start) < 1e-6 and part.distance(goal) < 1e-6
            for part in shapely.get_parts(hall)
        )
        low, high = (middle, high) if joined else (low, middle)
    return low


def check(kind, seed, difficulty, **options):
    """Checks one scenario as a file is checked, and by other means."""
    scenario = GenerateScenario(
        kind, seed=seed, difficulty=difficulty, **options
    )
    text = SaveScenario(scenario)
    loaded = LoadScenario(data=text, ways=True)
    CheckScenario(loaded)
    assert same_for_all_seeds(loaded) == ""
    assert clearance(scenario) > scenario.robot.radius
    walls = solids(scenario)
    free = walls.envelope.difference(walls.buffer(0.2))
    for human in scenario.humans:
        (room,) = (
            part
            for part in shapely.get_parts(free)
            if part.covers(shapely.Point(human.pose[:2]))
        )
        assert len(human.goals) > 0
        for goal in human.goals:
            assert room.distance(shapely.Point(goal)) <= human.goal_radius


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_its_goals_are_reached_and_it_has_no_fault(kind, seed):
    check(kind, seed, seed / 2)


def test_the_rooms_of_a_deep_office_have_doors():
    check("office", 17, 0.5, depth=7.5)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_forty_seeds_have_no_fault(kind):
    for seed in range(3, 43):
        check(kind, seed, (seed * 0.618) % 1)


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_text_and_others_another(kind):
    texts = [
        SaveScenario(GenerateScenario(kind, seed=seed)) for seed in (5, 5, 6)
    ]
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


def share(scenario):
    """Returns how much of a world is occupied."""
    walls = solids(scenario)
    return walls.area / walls.envelope.area


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_harder_worlds_are_narrower_and_fuller(kind):
    worlds = [
        [GenerateScenario(kind, seed=seed, difficulty=d) for seed in range(8)]
        for d in (0, 0.5, 1)
    ]
    widths = [np.mean([clearance(it) for it in part]) for part in worlds]
    shares = [np.mean([share(it) for it in part]) for part in worlds]
    assert widths == sorted(widths, reverse=True)
    assert widths[0] > 1.05 * widths[2]
    if kind != "corridors":
        # Walls of corridors are as many, and the narrower the farther apart.
        assert shares == sorted(shares)


def test_the_difficulties_of_seeds_are_spread_over_a_range():
    kind = make_kind({"type": "rooms", "difficulty": [0.2, 0.8]})
    found = np.sort([kind.difficulty_of(seed) for seed in range(25)])
    assert found[0] >= 0.2
    assert found[-1] <= 0.8
    assert np.diff(found).max() < 0.05
    alone = make_kind({"type": "rooms", "difficulty": 0.3})
    assert alone.difficulty_of(7) == pytest.approx(0.3)


def test_a_field_is_made_of_columns_in_cells():
    scenario = GenerateScenario(
        "field", seed=1, people=0, smoothing=0, fill=0.03
    )
    discs = [it for it in scenario.world.walls if isinstance(it, Disc)]
    # A share of 900 cells, by the binomial distribution.
    assert len(discs) == pytest.approx(27, abs=4 * 5.1)
    cells = np.array([it.center for it in discs]) / 0.15 - 0.5
    assert cells == pytest.approx(cells.round(), abs=1e-3)
    assert {it.radius for it in discs} == {0.075}


def test_walls_are_boxes_that_fill_what_is_around_a_floor_once():
    floor = shapely.union_all(
        [
            shapely.box(0, 0, 4, 3),
            shapely.box(4.15, 0, 8, 3),
            shapely.box(4, 1, 4.15, 2),
        ]
    )
    boxes = [shapely.Polygon(it.vertices()) for it in walls_around(floor)]
    whole = shapely.union_all(boxes)
    wanted = floor.buffer(0.15, join_style="mitre").difference(floor)
    assert whole.symmetric_difference(wanted).area < 1e-9
    assert sum(it.area for it in boxes) == pytest.approx(wanted.area)
    # Four sides, and the wall on both sides of the door.
    assert len(boxes) == 6


def test_people_have_behaviors_in_proportion_to_weights():
    scenario = GenerateScenario(
        "rooms",
        difficulty=0,
        people=30,
        width=30.0,
        behaviors={"scared": 1, "curious": 2},
    )
    names = [it.behavior for it in scenario.humans]
    assert set(names) == {"scared", "curious"}
    assert len(names) == 30
    # Within four deviations.
    assert abs(names.count("curious") - 20) < 4 * (30 * 2 / 9) ** 0.5


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"difficulty": 2}, r"difficulty: must be in \[0, 1\], got 2\.0"),
        ({"difficulty": "hard"}, "difficulty: "),
        ({"people": -1}, "people: must be at least 0, got -1"),
        ({"size": 3}, "size: there is no such option"),
        ({"behaviors": {"regulr": 1}}, "did you mean 'regular'"),
        ({"behaviors": {"regular": 0}}, "must have a weight above 0"),
        ({"robot_radius": 0}, "robot_radius: must be in"),
    ],
)
def test_bad_options_are_told_in_one_line(options, told):
    with pytest.raises(ValueError, match=told) as caught:
        GenerateScenario("rooms", **options)
    assert "\n" not in str(caught.value)


def test_an_unknown_kind_and_a_world_without_room_are_told():
    with pytest.raises(ValueError, match="did you mean 'rooms'"):
        GenerateScenario("roms")
    with pytest.raises(ValueError, match=r"lower difficulty, people") as caught:
        GenerateScenario("field", fill=0.9, people=0)
    assert "100 draws" in str(caught.value)
    with pytest.raises(ValueError, match="seed must be a whole number"):
        GenerateScenario("rooms", seed=-1)


@pytest.mark.slow
def test_draws_are_counted_and_stay_the_same():
    kind = make_kind({"type": "field", "difficulty": 1, "people": 0})
    first = [draw_scenario(kind, seed)[1] for seed in range(3)]
    assert first == [draw_scenario(kind, seed)[1] for seed in range(3)]
    assert max(first) > 1


@pytest.mark.parametrize("kind", ["rooms", "office"])
def test_furniture_stands_in_no_wall_and_in_no_other(kind):
    scenario = GenerateScenario(kind, seed=2, difficulty=1, people=0)
    fixtures = scenario.world.fixtures()
    shapes = [
        (fixture.place[0], shapely.Polygon(outline))
        for fixture in fixtures
        for outline in fixture.footprints
    ]
    for (kind_a, a), (kind_b, b) in itertools.combinations(shapes, 2):
        if "furniture" in (kind_a, kind_b):
            assert a.intersection(b).area < 1e-4
