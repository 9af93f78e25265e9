"""No number that a scenario may have makes a trial hang, fail or swell."""

import json

import pytest

from hunav_drake import LoadScenario, ScenarioError
from tests.reliability import option_extremes
from tests.reliability.option_extremes import Case, cases, main, outcome

# What steers loops, or sizes of arrays.
STEERING = (
    "planner[sfw].sim",
    "planner[sfw].inflation_radius",
    "planner[sfw].local_costmap",
    "planner[dwb].linear_granularity",
    "planner[dwb].angular_granularity",
    "planner[dwb].time_granularity",
    "simulation.time_step",
)


def test_all_numbers_of_the_schema_are_tried():
    found = cases()
    places = {case.place for case in found}
    assert len(places) > 500
    assert {"simulation.time_step", "planner[sfw].sim_granularity"} <= places
    assert "crowd.model[orca].body_radius" in places


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("planner[sfw].sim_granularity", 1e-6),
        ("planner[sfw].inflation_radius", 1e3),
        ("planner[dwb].linear_granularity", 1e-9),
    ],
)
def test_what_would_hang_is_refused(place, value):
    data = {"planner": {"type": place[8:11], place[13:]: value}}
    with pytest.raises(ScenarioError, match=r"must be in [\[(]0"):
        LoadScenario(data=json.dumps(data))


@pytest.mark.slow
@pytest.mark.parametrize("prefix", STEERING)
def test_extremes_do_no_harm(prefix, capfd):
    assert main([prefix]) == 0, capfd.readouterr().out


@pytest.mark.slow
def test_what_hangs_or_fails_is_found(monkeypatch):
    def run(scenario):
        while scenario.name == "endless":
            pass
        raise MemoryError("all of it")

    monkeypatch.setattr(option_extremes, "RunTrial", run)
    monkeypatch.setattr(option_extremes, "LIMIT", 1)
    data = {"name": "endless"}
    assert outcome(Case("name", "endless", data)).startswith("hangs")
    assert outcome(Case("name", "", {})) == "fails: MemoryError: all of it"
    assert "refused" in outcome(Case("nmae", "", {"nmae": 1}))
