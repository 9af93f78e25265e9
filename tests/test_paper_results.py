"""What the docs print of the paper's tables is what the suite gives."""

import dataclasses
import json
from pathlib import Path
import re
from statistics import fmean

import pytest

from hunav_drake.runs import LoadSuite, RunSuite
from tests.paper_results import FILE, ROWS, values_of

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text()
PAGE = (ROOT / "docs" / "paper_results.md").read_text()


@pytest.fixture(scope="module")
def kept():
    return json.loads(FILE.read_text())


def test_the_means_of_the_page_are_those_of_all_runs(kept):
    printed = [
        re.findall(r" ([\d.]+) \| \*", row)
        for row in re.findall(r"^\|.*\d\* \|$", PAGE, re.M)
    ]
    assert len(printed) == len(ROWS) == len(kept["values"])
    for row, of_planners in zip(printed, kept["values"].values(), strict=True):
        for text, values in zip(row, of_planners.values(), strict=True):
            digits = len(text.partition(".")[2])
            assert text == f"{fmean(values):.{digits}f}"
            assert len(values) in (10, 30)


def test_the_relations_are_counted_as_they_were_judged(kept):
    held, surely, strong = kept["holds"]["strong"]
    medium, weak = kept["holds"]["medium"], kept["holds"]["weak"]
    told = (
        f"{held} of {strong} strong ones are true here, {medium[0]} of"
        f" {medium[2]} medium ones and {weak[0]} of {weak[2]} weak ones"
    )
    assert told in README
    assert f"{strong - held} of {strong} strong relations fail" in README
    assert f"{surely} of them also in nine of ten resamples" in PAGE
    suite = LoadSuite(filename="paper")
    for strength in ("medium", "weak"):
        held_here, _, tested = kept["holds"][strength]
        counts = f"{held_here} of {tested}"
        assert f"{counts} {strength} ones" in PAGE
        relations = [r for r in suite.relations if r.strength == strength]
        assert len(relations) == tested
    assert f"together {held} of {strong}, {100 * held / strong:.0f} %" in PAGE


@pytest.mark.slow
def test_the_first_run_of_each_cell_is_as_it_was(kept):
    """If not, `tests/paper_results.py` tells how to measure all anew."""
    suite = dataclasses.replace(
        LoadSuite(filename="paper"),
        scenarios=["passing", "crossing", "combined"],
        seeds=1,
        seeds_of={},
        relations=[],
        identities=False,
    )
    result = RunSuite(suite, workers=1)
    now = values_of(result.runs(), result.runs(by_behavior=True))
    for row, of_planners in kept["values"].items():
        assert {p: values[0] for p, values in of_planners.items()} == {
            p: pytest.approx(values[0], rel=1e-3, abs=1e-3)
            for p, values in now[row].items()
        }
