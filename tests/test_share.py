"""`pytest --share K/N` runs a part of the cases of slow tests."""

from types import SimpleNamespace

from hypothesis import given, strategies as st

from tests.conftest import pytest_collection_modifyitems

TESTS = {"many": 10, "few": 3, "alone": 1, "fast": 8}


def run(share):
    """Returns the cases that run, and those that are left out."""
    items = [
        SimpleNamespace(
            nodeid=f"tests/a.py::{name}[{i}]",
            get_closest_marker=lambda _, name=name: name != "fast" or None,
        )
        for name, count in TESTS.items()
        for i in range(count)
    ]
    left_out = []
    pytest_collection_modifyitems(
        SimpleNamespace(
            getoption=lambda _: share,
            hook=SimpleNamespace(
                pytest_deselected=lambda items: left_out.extend(items)
            ),
        ),
        items,
    )
    return [[it.nodeid for it in part] for part in (items, left_out)]


def test_without_the_option_all_run():
    assert run(None)[1] == []


@given(st.integers(4, 7))
def test_each_case_of_many_is_in_one_share_and_all_else_in_each(shares):
    cases = [run(f"{k}/{shares}") for k in range(shares)]
    for name, count in TESTS.items():
        times = [
            sum(f"{name}[{i}]" in it for it, _ in cases for it in it)
            for i in range(count)
        ]
        assert times == [1 if name == "many" else shares] * count
    everything = sorted(run(None)[0])
    for ran, left_out in cases:
        assert sorted(ran + left_out) == everything
