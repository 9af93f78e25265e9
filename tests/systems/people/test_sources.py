"""The people of sources, and the places where they come in."""

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from scipy.spatial.distance import pdist

from hunav_drake.systems.people.area import Area
from hunav_drake.systems.people.population import (
    PopulationError,
    draw_population,
    draw_with_traffic,
)
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    PopulationConfig,
    SinkConfig,
    SourceConfig,
)
from hunav_drake.systems.people.traffic import place_party
from hunav_drake.systems.world.obstacles import Obstacles

NO_WALLS = Obstacles.from_shapes([], solid=[])
HALL = Area(rectangle=[0, 0, 20, 10])
SINKS = [
    SinkConfig(name="left", area=Area(rectangle=[30, 0, 31, 4])),
    SinkConfig(name="right", area=Area(point=[30, 9])),
]


def source(name="door", **values):
    options = {"start": [HALL], "rate": 0.1, "max_present": 30}
    return SourceConfig(
        name=name, **{**options, "sinks": {"left": 1}, **values}
    )


def drawn(*sources, cohorts=(), obstacles=NO_WALLS):
    config = PopulationConfig(
        seed=2, cohorts=list(cohorts), sources=list(sources), sinks=SINKS
    )
    return draw_with_traffic(config, obstacles)


@settings(max_examples=40)
@given(data=st.data())
def test_a_party_has_room_or_does_not_come_in(data):
    seed = data.draw(st.integers(0, 10**6))
    rng = np.random.default_rng(seed)
    m, k = rng.integers(1, 6), rng.integers(1, 40)
    places = rng.uniform(0, rng.uniform(0.1, 3), (k, 2))
    free = rng.random((m, k)) < rng.uniform(0.2, 1)
    bodies = rng.uniform(0.2, 0.3, m)
    spacing = rng.uniform(0, 0.2)
    got = place_party(places, free, bodies.tolist(), spacing)
    if got is None:
        assert m > 1 or not free.any()
        return
    assert got.shape == (m, 2)
    for i, point in enumerate(got):
        at = (places == point).all(axis=1)
        assert free[i, at].any()
    if m > 1:
        least = [
            bodies[i] + bodies[j] + spacing
            for i in range(m)
            for j in range(i + 1, m)
        ]
        assert (pdist(got) >= np.array(least) - 1e-12).all()


def test_the_first_place_that_is_free_is_taken():
    places = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    free = np.array([[False, True, True]])
    got = place_party(places, free, [0.25], 0.1)
    assert got.tolist() == [[1.0, 0.0]]


def test_sources_come_after_cohorts_and_know_their_rows():
    cohort = CohortConfig(number=4, start=[HALL])
    people, traffic = drawn(
        source(group_sizes=[1, 1]), source("gate"), cohorts=[cohort]
    )
    assert len(people) == 64
    assert traffic.pool() == list(range(4, 64))
    first, second = traffic.sources
    assert {people[row].name for row in first.parties[0]} <= {
        "door_1",
        "door_2",
    }
    assert people[second.parties[0][0]].name == "gate_1"
    for party in first.parties:
        groups = {people[row].group_id for row in party}
        assert groups == {-1} if len(party) == 1 else len(groups) == 1
    assert (traffic.sink_of[:4] == -1).all()


def test_a_source_changes_nobody_of_a_cohort_or_another_source():
    cohort = CohortConfig(number=4, start=[HALL], name="guest", goals=[HALL])
    alone = draw_population(
        PopulationConfig(seed=2, cohorts=[cohort]), NO_WALLS
    )
    both = drawn(source(), source("gate"), cohorts=[cohort]).people
    assert both[:4] == alone
    assert drawn(source("gate")).people == both[34:]


def test_the_last_goal_is_in_the_sink_that_was_drawn():
    people, traffic = drawn(
        source(max_present=400, sinks={"left": 3, "right": 1}, goals=[HALL])
    )
    goals = np.array([human.goals for human in people])
    assert goals.shape == (400, 2, 2)
    np.testing.assert_array_equal(goals[:, 1], traffic.exits)
    left = traffic.sink_of == 0
    assert (goals[left, 1, 0] >= 30.0).all()
    assert (goals[left, 1, 1] <= 4.0).all()
    assert (goals[~left, 1] == [30, 9]).all()
    assert left.mean() == pytest.approx(0.75, abs=0.07)
    assert not any(human.cyclic for human in people)


def test_without_sources_and_sinks_nobody_comes_or_goes():
    cohort = CohortConfig(number=4, start=[HALL])
    assert drawn(cohorts=[cohort]).traffic is None


def test_all_faults_are_told():
    wall = np.array([[-1.0, -1.0], [21.0, -1.0], [21.0, 11.0], [-1.0, 11.0]])
    walls = Obstacles.from_shapes([wall], solid=[True])
    with pytest.raises(PopulationError) as info:
        drawn(source(), source("gate", max_present=1), obstacles=walls)
    assert [(it.kind, it.cohort, it.key) for it in info.value.faults] == [
        ("sources", 0, "start"),
        ("sources", 1, "start"),
    ]
    assert "sources[0].start: has no place 0.35 m from" in str(info.value)


def test_the_least_number_is_that_of_littles_law():
    """Straight on at 1 m/s, 20 m less two radii of goals, at 1 person/s."""
    values = {
        "start": [Area(point=[10, 9])],
        "sinks": {"right": 1},
        "speed": {"mean": 1.0},
        "rate": 1.0,
    }
    assert drawn(source(**values, max_present=20)).people
    with pytest.raises(PopulationError, match="must be at least 20 for 1 pe"):
        drawn(source(**values, max_present=19))
