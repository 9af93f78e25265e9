import math

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from hunav_drake.runs.run_row import RunRow, row_to_json
from hunav_drake.runs.run_table import RunTable

numbers = st.floats(allow_nan=True, allow_infinity=True)
values = st.dictionaries(st.sampled_from("abcd"), numbers, max_size=4)
rows = st.builds(
    RunRow,
    scenario=st.just("x"),
    planner=st.sampled_from(["dwb", "sfw"]),
    setting=st.sampled_from(["", "fast"]),
    drawn=st.sampled_from(["", "nothing"]),
    sha256=st.sampled_from(["0", "1"]),
    code_sha256=st.sampled_from(["a", "b"]),
    seed=st.none() | st.integers(0, 2**63 - 1),
    repetition=st.integers(0, 3),
    end_reason=st.sampled_from(["goal", "error"]),
    end_message=st.text(max_size=5),
    end_time=numbers,
    metrics=values,
    by_behavior=st.dictionaries(
        st.sampled_from(["regular", "curious"]), values
    ),
    cost=values,
    extras=values,
)


def texts(table):
    # As text, since NaN does not equal itself.
    return [row_to_json(row) for row in table]


@settings(max_examples=25)
@given(st.lists(rows, max_size=12), st.randoms())
def test_holds_rows_to_the_last_bit_in_any_order(made, random):
    table = RunTable(made)
    assert texts(table) == texts(made)
    order = list(range(len(made)))
    random.shuffle(order)
    chosen = order[: len(order) // 2 + 1]
    part = table.sorted(np.array(chosen, dtype=int))
    assert texts(part) == texts([made[i] for i in chosen])
    columns = part.columns("metrics")
    assert set(columns) == {name for i in chosen for name in made[i].metrics}
    for name, column in columns.items():
        told = [made[i].metrics.get(name, math.nan) for i in chosen]
        np.testing.assert_array_equal(column, told)


@settings(max_examples=25)
@given(st.lists(rows, max_size=12))
def test_tells_who_has_behaviors(made):
    frame = RunTable(made).frame(by_behavior=True)
    for behavior in ("regular", "curious"):
        having = [it for it in made if it.by_behavior.get(behavior)]
        own = frame[frame.behavior == behavior] if len(frame) else frame
        assert len(own) == len(having)
        for (_, told), row in zip(own.iterrows(), having, strict=True):
            assert told["planner"] == row.planner
            for name, value in row.by_behavior[behavior].items():
                np.testing.assert_equal(told[name], value)


@pytest.mark.slow
def test_takes_little_memory():
    def row(seed):
        metrics = {f"metric_{i}": seed + i / 7 for i in range(60)}
        return RunRow(
            *("x", "dwb", "", seed, "goal", "done", 1.0, metrics, {}),
            **{"sha256": "0" * 64, "code_sha256": "1" * 64},
        )

    import tracemalloc

    # (Python keeps up to 2000 tuples that are free: rows that come and go.)
    RunTable(row(seed) for seed in range(2000))
    tracemalloc.start()
    try:
        table = RunTable(row(seed) for seed in range(2000))
        size, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(table) == 2000
    assert size / 2000 < 60 * 8 * 1.25 + 100


def test_failed_runs_count_only_for_the_robots_of_their_scenario():
    def row(scenario, seed, metrics=None, setting=""):
        end = "error" if metrics is None else "goal"
        about = scenario, "dwb", setting, seed, end, "", 1.0
        return RunRow(*about, metrics or {}, {})

    nan = math.nan
    table = RunTable(
        [
            row("one", 0, {"completed": 1.0}),
            row("one", 1),
            row("two", 0, {"a.completed": 1.0, "b.completed": 0.0}),
            row("two", 1),
            row("broken", 0),
            row("one", 0, setting="bad"),
            # This one has no goals.
            row("free", 0, {"completed": nan}),
            row("free", 1),
        ]
    ).frame()
    names = ["completed", "a.completed", "b.completed"]
    np.testing.assert_array_equal(
        table[names],
        [
            *([1.0, nan, nan], [0.0, nan, nan], [nan, 1.0, 0.0]),
            *([nan, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, nan, nan]),
            *([nan, nan, nan], [nan, nan, nan]),
        ],
    )
    other = RunTable([row("x", 0, {"path_length": 1.0}), row("x", 1)]).frame()
    assert "completed" not in other
    assert RunTable([row("x", 0)]).frame()["completed"].tolist() == [0.0]
