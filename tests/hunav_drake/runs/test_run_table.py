import math

from hypothesis import given, settings, strategies as st
import numpy as np

from hunav_drake.runs.running.run_row import RunRow, row_to_json
from hunav_drake.runs.running.run_table import METRICS, RunTable, behavior_group

numbers = st.floats(allow_nan=True, allow_infinity=True)
values = st.dictionaries(st.sampled_from("abcd"), numbers, max_size=4)
rows = st.builds(
    RunRow,
    cell=st.sampled_from(["x/dwb", "x/sfw"]),
    sha256=st.sampled_from(["0", "1"]),
    code_sha256=st.sampled_from(["a", "b"]),
    seed=st.integers(0, 2**63 - 1),
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


@settings(max_examples=25, deadline=None)
@given(st.lists(rows, max_size=12), st.randoms())
def test_holds_rows_to_the_last_bit_in_any_order(made, random):
    table = RunTable(made)
    assert texts(table) == texts(made)
    order = list(range(len(made)))
    random.shuffle(order)
    chosen = order[: len(order) // 2 + 1]
    part = table.sorted(np.array(chosen, dtype=int))
    assert texts(part) == texts([made[i] for i in chosen])
    columns = part.columns(METRICS)
    assert set(columns) == {name for i in chosen for name in made[i].metrics}
    for name, column in columns.items():
        told = [made[i].metrics.get(name, math.nan) for i in chosen]
        np.testing.assert_array_equal(column, told)


@settings(max_examples=25, deadline=None)
@given(st.lists(rows, max_size=12))
def test_tells_who_has_behaviors(made):
    table = RunTable(made)
    assert set(table.behaviors()) == {
        b for row in made for b in row.by_behavior
    }
    for behavior in ("regular", "curious"):
        places, _ = table.places(behavior_group(behavior))
        having = [
            i for i, row in enumerate(made) if row.by_behavior.get(behavior)
        ]
        assert list(places) == having


def test_takes_little_memory():
    def row(seed):
        metrics = {f"metric_{i}": seed + i / 7 for i in range(60)}
        return RunRow(
            *("cell", "0" * 64, "1" * 64, seed, 0, "goal", "done", 1.0),
            *(metrics, {}, {}, {}),
        )

    import tracemalloc

    tracemalloc.start()
    try:
        table = RunTable(row(seed) for seed in range(2000))
        size, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(table) == 2000
    assert size / 2000 < 60 * 8 * 1.25 + 100
