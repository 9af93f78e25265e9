"""The cases, and what becomes of models that are good or bad at them."""

import dataclasses
import math

import pytest

from hunav_drake.systems.crowd import MOTION_MODELS, SocialForceModel
from hunav_drake.validation.case import Case, Setting, describe, judge
from hunav_drake.validation.cases import CASES, TOPICS
from hunav_drake.validation.run import run_cases, select_cases, select_models

MODELS = sorted(
    name
    for name, model in MOTION_MODELS.items()
    if model.__module__.startswith("hunav_drake.")
)

# Those that take the least time.
FAST = ("corridor_time", "kept_speed", "corner", "shorter_way", "fast_group")


@dataclasses.dataclass(kw_only=True)
class Sluggish(SocialForceModel):
    """People who walk at half of their speed, and through walls."""

    def advance(self, snapshot, forces):
        states = super().advance(snapshot, forces).copy()
        half = (states[:, :2] - snapshot.states[:, :2]) / 2
        states[:, :2] = snapshot.states[:, :2] + half
        return states


@dataclasses.dataclass(kw_only=True)
class Broken(SocialForceModel):
    """A model that forgets somebody."""

    def advance(self, snapshot, forces):
        return super().advance(snapshot, forces)[:-1]


@pytest.fixture
def own_models(monkeypatch):
    known = dict(MOTION_MODELS._choices)
    monkeypatch.setattr(MOTION_MODELS, "_choices", known)
    MOTION_MODELS.register("sluggish")(Sluggish)
    MOTION_MODELS.register("broken")(Broken)


@pytest.mark.parametrize("case", CASES.values(), ids=list(CASES))
def test_a_case_says_what_it_asks(case):
    assert case.question.endswith(("?", ".", "again."))
    assert case.expected
    assert (case.measure is None) == bool(case.reason)
    assert bool(case.shown) == (case.measure is not None)


def test_names_are_unique():
    assert sum(map(len, TOPICS.values())) == len(CASES)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", FAST)
def test_what_all_models_can_do(model, name):
    outcome = judge(CASES[name], Setting(model, quick=True))
    assert outcome.verdict == "passes", outcome


@pytest.mark.slow
@pytest.mark.parametrize("first", range(len(MODELS)))
def test_every_case_measures_something_in_its_quick_form(first):
    """Each with one model, in turn; with another than in `test_page.py`."""
    setting = Setting(MODELS[first - 1], quick=True)
    for outcome in run_cases(list(CASES)[first :: len(MODELS)], [setting]):
        assert outcome.verdict in ("passes", "fails", "not applicable")
        if CASES[outcome.case].measure is not None:
            assert outcome.reason == ""
            assert outcome.numbers
            assert "nan" not in outcome.measured


@pytest.mark.slow
def test_a_slow_model_fails_what_is_about_speed(own_models):
    setting = Setting("sluggish", quick=True)
    for name in ("corridor_time", "kept_speed", "population_speeds"):
        outcome = judge(CASES[name], setting)
        assert outcome.verdict == "fails"
        assert outcome.reason == ""
    speed = judge(CASES["kept_speed"], setting).numbers["speed"]
    assert speed == pytest.approx(0.5, abs=0.02)


def test_a_model_that_raises_fails_with_its_error(own_models):
    outcome = judge(CASES["kept_speed"], Setting("broken", quick=True))
    assert outcome.verdict == "fails"
    assert "'broken' must give an array of shape (1, 6)" in outcome.reason


def test_a_case_that_cannot_be_asked_is_no_failure():
    case = Case("a", "RiMEA 0", "Is it?", "yes", reason="there is no lift")
    outcome = judge(case, Setting("social_force"))
    assert outcome.verdict == "not applicable"
    assert outcome.reason == "there is no lift"


def test_numbers_are_told_one_by_one():
    text = describe(
        "{a:.1f} at {b:g} m, {c:.0f}",
        {"a": [1.25, math.inf], "b": [1, 2.5], "c": 3},
    )
    assert text == "1.2 / never at 1 / 2.5 m, 3"
    assert describe("{a:.1f} s", {"a": [1, math.inf]}) == "1.0 / never"


def test_draws_follow_from_seed_and_purpose():
    draws = {
        (seed, purpose): Setting("orca", seed).generator(purpose).random()
        for seed in (0, 1)
        for purpose in ("a", "b")
    }
    assert len(set(draws.values())) == 4
    assert draws[0, "a"] == Setting("social_force").generator("a").random()


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_processes():
    settings = [Setting(model, 3, quick=True) for model in MODELS[:2]]
    names = ["corner", "head_on"]
    alone = run_cases(names, settings)
    assert [(o.case, o.model) for o in alone] == [
        (name, setting.model) for name in names for setting in settings
    ]
    assert run_cases(names, settings, workers=2) == alone


def test_models_and_cases_are_selected_in_order():
    assert select_cases() == list(CASES)
    assert select_cases(["lanes", "corner"]) == ["corner", "lanes"]
    assert set(select_models()) == set(MOTION_MODELS)
    with pytest.raises(
        ValueError, match="no motion model 'orka'; did you mean"
    ):
        select_models(["orka"])
    with pytest.raises(ValueError, match=r"no case 'x' .there are: corridor"):
        select_cases(["x"])
