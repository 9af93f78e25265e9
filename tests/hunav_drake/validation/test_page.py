"""The page of the validation tells what the command finds.

`hunav validate --markdown docs/validation.md --workers 2` writes it anew.
"""

from pathlib import Path
import re

import numpy as np
import pytest

from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.validation.case import VERDICTS, Outcome, Setting, judge
from hunav_drake.validation.cases import CASES
from hunav_drake.validation.diagrams import fundamental_diagram
from hunav_drake.validation.measures import weidmann
from hunav_drake.validation.page import _overview, _section, _summary

PAGE = (Path(__file__).parents[3] / "docs/validation.md").read_text()

# It takes the least time, and yet tells if people walk otherwise.
FAST = "kept_speed"
# These take little, and are found with all models.
SHORT = ("own_times", "population_speeds", "corner_effect")
MEASURED = [name for name, case in CASES.items() if case.measure is not None]

ROW = re.compile(rf"\| (\w+) \| ({'|'.join(VERDICTS)}) \| (.*) \|")


def rows_of(name):
    """The rows of a case in the page, as (model, verdict, text)."""
    _, _, rest = PAGE.partition(f"\n### {name}\n")
    return ROW.findall(rest.partition("\n#")[0])


def told_by_page():
    """The outcomes as the page has them; their numbers are only text."""
    models = [model for model, _, _ in rows_of(MEASURED[0])]
    for name, case in CASES.items():
        rows = rows_of(name)
        if case.measure is None:
            rows = [(model, "not applicable", "") for model in models]
        for model, verdict, text in rows:
            yield Outcome(name, model, verdict, text.replace(r"\|", "|"))


def test_the_page_has_the_cases_as_they_are():
    """Questions and rules, all models, and an overview of just these rows."""
    outcomes = list(told_by_page())
    # Other tests may have registered more.
    models = [
        name
        for name, model in sorted(MOTION_MODELS.items())
        if model.__module__.startswith("hunav_drake.")
    ]
    overview = "\n".join(_overview(outcomes, models))
    assert f"\n{overview}\n" in PAGE
    for name, case in CASES.items():
        own = [outcome for outcome in outcomes if outcome.case == name]
        assert [outcome.model for outcome in own] == models
        section = "\n".join(_section(case, own))
        assert f"\n{section}" in PAGE


def assert_up_to_date(name, models):
    found = []
    for model in models:
        outcome = judge(CASES[name], Setting(model))
        found += ROW.findall("\n".join(_section(CASES[name], [outcome])))
    assert [row for row in rows_of(name) if row[0] in models] == found, (
        "hunav validate --markdown docs/validation.md --workers 2"
        " writes the page anew"
    )


def test_the_page_tells_what_the_command_finds():
    assert_up_to_date(FAST, sorted(MOTION_MODELS))


@pytest.mark.slow
@pytest.mark.parametrize("model", ["headed_social_force", "social_force"])
def test_a_hundred_get_past_a_hundred(model):
    name = "dense_counterflow"
    assert_up_to_date(name, [model])
    assert (model, "passes") in [row[:2] for row in rows_of(name)]


@pytest.mark.slow
@pytest.mark.parametrize("name", SHORT)
def test_the_page_tells_what_the_command_finds_with_all_models(name):
    assert_up_to_date(name, sorted(MOTION_MODELS))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [it for it in MEASURED if it not in (FAST, *SHORT, "dense_counterflow")],
)
def test_the_whole_page_tells_what_the_command_finds(name):
    """Each case with one model, in turn."""
    models = sorted(MOTION_MODELS)
    assert_up_to_date(name, [models[MEASURED.index(name) % len(models)]])


@pytest.mark.parametrize("place", range(5))
@pytest.mark.parametrize("off", [-0.16, 0.16])
def test_the_speed_at_each_density_counts(place, off):
    """However near the others are to what was measured in people."""
    densities = [0.5, 1.0, 1.5, 2.0, 3.0]
    difference = np.zeros(5)
    numbers = {"speed": weidmann(densities), "difference": difference}
    assert fundamental_diagram.accepts(numbers)
    difference[place] = 0.9 * off
    assert fundamental_diagram.accepts(numbers)
    difference[place] = off
    assert not fundamental_diagram.accepts(numbers)


def test_the_summary_counts_what_applies():
    outcomes = [
        Outcome(case, model, verdict)
        for case, verdicts in {
            "own_times": ("passes", "passes"),
            "corner_effect": ("fails", "fails"),
            "kept_speed": ("passes", "fails"),
            "elsewhere": ("not applicable", "not applicable"),
        }.items()
        for model, verdict in zip(("a", "b"), verdicts, strict=True)
    ]
    assert _summary(outcomes) == [
        "Cases passed: a 2 of 3, b 1 of 3.",
        "All models to which a case applies pass 1 of 3.",
        "None passes corner_effect.",
    ]
    assert _summary(outcomes[-2:]) == ["No case applies."]
