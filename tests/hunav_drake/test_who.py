"""Who delayed whom: leave-one-out and Shapley values."""

import itertools

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram, WhoDelayedWhom
from hunav_drake.trial.branches.kinds import Without
from hunav_drake.trial.branches.run import Fork
from hunav_drake.trial.branches.who import _drawn, _exact, _without_one
from tests.hunav_drake.test_branches import PAIR, at, stage, walker


def game(effects, together):
    """Arrivals: each other one costs something, and two together more."""

    def arrivals(there):
        alone = 10.0 + effects[:3, list(there)].sum(axis=1)
        return alone + together * (len(there) - 1) ** 2

    return arrivals


numbers = st.lists(st.floats(-5, 5), min_size=12, max_size=12).map(
    lambda it: np.reshape(it, (3, 4))
)


@given(numbers, st.floats(-2, 2))
def test_shapley_values_add_up_and_find_what_each_costs(effects, together):
    effects[range(3), range(3)] = 0.0
    play = game(effects, together)
    table = _exact(play, 4, 3)
    total = np.nansum(table, axis=0)
    everybody = frozenset(range(4))  # Three people and a robot.
    for i in range(3):
        alone = play(frozenset({i}))[i]
        assert total[i] == pytest.approx(play(everybody)[i] - alone, abs=1e-9)
    # What all do together is shared equally.
    share = together * 9 / 3
    for i, j in itertools.permutations(range(3), 2):
        assert table[j, i] == pytest.approx(effects[i, j] + share, abs=1e-9)
    every_order = list(itertools.permutations(range(4)))
    drawn = _drawn(play, 3, every_order)
    np.testing.assert_allclose(drawn, table, atol=1e-9)
    if not together:
        np.testing.assert_allclose(_without_one(play, 4, 3), table, atol=1e-9)


@pytest.mark.slow
def test_columns_add_up_in_a_trial():
    scenario = stage([*PAIR, walker("eva", -6, 0.5, 6)])
    diagram, context = at(scenario, 1.0)
    table = WhoDelayedWhom(
        scenario, diagram, context, until=18.0, method="shapley"
    )
    assert list(table.index) == ["ana", "luis", "eva", "robot"]
    fork = Fork(scenario, diagram, context, until=18.0)
    everybody = fork.Run(Without()).arrivals
    for i, name in enumerate(fork.names):
        others = tuple(it for it in fork.names if it != name)
        alone = fork.Run(Without(people=others, robots=("robot",))).arrivals
        assert table[name].sum() == pytest.approx(
            everybody[i] - alone[i], abs=1e-9
        )
        assert np.isnan(table.loc[name, name])
    drawn = WhoDelayedWhom(
        scenario, diagram, context, until=18.0, method="shapley", permutations=3
    )
    np.testing.assert_allclose(drawn.sum(), table.sum(), atol=1e-9)


@pytest.mark.slow
def test_a_person_may_be_called_robot():
    tables = []
    for name in ("ana", "robot"):
        scenario = stage([walker(name, 5, 0, -6), PAIR[1]])
        diagram = MakeTrialDiagram(scenario)
        context = diagram.CreateDefaultContext()
        table = WhoDelayedWhom(scenario, diagram, context, until=15.0)
        assert list(table.index) == [name, "luis", "robot"]
        tables.append(table.to_numpy())
    np.testing.assert_equal(tables[1], tables[0])


def test_the_robot_in_the_way_delays_whom_it_meets():
    """And nobody else, who is far from it."""
    people = [walker("ana", 5, 0.4, -6), walker("far", 5, 40, -6)]
    scenario = stage(people)
    diagram = MakeTrialDiagram(scenario)
    table = WhoDelayedWhom(
        scenario, diagram, diagram.CreateDefaultContext(), until=18.0
    )
    assert table.loc["robot", "ana"] > 0.05
    assert table.loc["robot", "far"] == 0.0
    assert table.loc["ana", "far"] == 0.0


@pytest.mark.slow
def test_who_does_not_arrive_has_no_value():
    scenario = stage([*PAIR, walker("long", 0, 9, 90)])
    diagram, context = at(scenario, 0.0)
    table = WhoDelayedWhom(scenario, diagram, context, until=15.0)
    assert table["long"].isna().all()
    assert table.loc["robot"].drop("long").notna().all()


@pytest.mark.slow
def test_mistakes_are_told():
    scenario = LoadScenario(filename="crossing")
    diagram, context = at(scenario, 0.0)
    for words, wrong in (
        ("method: there is no", {"method": "guess"}),
        ("permutations must be at least 1", {"permutations": 0}),
        ("permutations=9 has no effect without", {"permutations": 9}),
        ("until must be a time", {"until": 0.0}),
    ):
        with pytest.raises(ValueError, match=words):
            WhoDelayedWhom(
                scenario, diagram, context, **{"until": 5.0, **wrong}
            )
    physical = LoadScenario(filename="crossing", overrides=["robot.type=pmb2"])
    diagram, context = at(physical, 0.0)
    with pytest.raises(ValueError, match="is physical"):
        WhoDelayedWhom(physical, diagram, context, until=5.0)
