"""Every choice goes with every other: see `crosswise/__main__.py`."""

import pytest

from hunav_drake.systems.planning import PLANNERS
from tests.choices import shipped
from tests.crosswise.children import run_apart
from tests.crosswise.factors import GIVEN, factors, overrides, refusal
from tests.crosswise.rows import (
    all_pairs,
    covered,
    pair_rows,
    random_rows,
    refused_rows,
)
from tests.crosswise.trial import run_row

# In so many parts the rows run, for machines of several cores.
PARTS = 4


@pytest.fixture(scope="module")
def rows():
    return pair_rows()


def num_exclusive(path):
    """Returns the number of levels of which a row has one.

    They are those of a factor, and in place of one of them those that another
    factor has with it alone.
    """
    own = {level: [1] for level in factors()[path].levels}
    for level, counts in own.items():
        counts += [
            len(it.levels)
            for it in factors().values()
            if it.owners == {(path, level)}
        ]
    return sum(map(max, own.values()))


@pytest.mark.slow
def test_each_pair_is_in_a_row_that_is_not_refused(rows):
    assert not any(map(refusal, rows))
    found = {pair for row in rows for pair in covered(row)}
    pairs = all_pairs()
    assert len(pairs) > 10_000
    assert found >= set(pairs)
    # As few as there must be, and some more.
    most = sorted(map(num_exclusive, factors()))[-2:]
    assert len(rows) < 1.5 * most[0] * most[1]


def test_what_is_registered_and_what_the_schema_offers_joins_by_itself():
    assert factors()["planner"].levels == tuple(shipped(PLANNERS))
    assert factors()["crowd.keep_apart"].levels == (GIVEN, "true", "false")
    kernel = factors()["crowd.model.kernel"]
    assert "reference" in kernel.levels
    assert kernel.owners == {("crowd.model", "social_force")}


def test_a_choice_of_a_choice_counts_only_with_it():
    (row,) = random_rows(1, seed=0)
    row |= {"planner": "pursuit", "planner.sees": "everything"}
    text = " ".join(overrides(row))
    assert "planner.sees=" in text
    assert "planner.sees.hidden_by_people" not in text
    assert "planner.smooth_plan" not in text


@pytest.mark.slow
def test_who_brings_a_child_down_is_known_and_the_others_run(monkeypatch):
    monkeypatch.setattr("tests.crosswise.children.LIMIT", 3.0)
    expected = {
        "sound = 1": "",
        "import os; os.abort()": "ended by SIGABRT",
        "sound = 2": "",
        "import os; os._exit(3)": "ended the process with 3",
        "raise ValueError('no')": "ValueError: no",
        "import time; time.sleep(60)": "took longer than 3 s",
        "sound = 3": "",
    }
    told = dict(run_apart(exec, expected))
    assert told.keys() == expected.keys()
    for code, words in expected.items():
        assert words in told[code]
        assert bool(words) == bool(told[code])


@pytest.mark.parametrize("row", refused_rows(), ids=lambda it: refusal(it)[:9])
def test_what_is_refused_says_why(row):
    run_row(row)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_every_choice_goes_with_every_other(rows, part):
    failed = [
        (overrides(row), failure)
        for row, failure in run_apart(run_row, rows[part::PARTS])
        if failure
    ]
    assert not failed


@pytest.mark.slow
def test_choices_drawn_at_random_go_together():
    drawn = random_rows(20, seed=1)
    assert not [it for it in run_apart(run_row, drawn) if it[1]]
