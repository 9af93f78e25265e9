"""The compact set of recorded results is what it says it is."""

import json

import pytest

from tests.data.make_reference import CASES, read_full, reduce
from tests.recorded import COMPACT, FULL, read_compact


def test_the_compact_set_is_small_and_has_every_kind():
    files = list(COMPACT.rglob("*.json.xz"))
    assert sum(path.stat().st_size for path in files) <= 1.5e6
    kinds = {path.parent.name for path in files}
    assert kinds == {"reference", "crowd", "metrics", "metrics_hand"}


def test_the_compact_set_is_a_part_of_the_full_one():
    names = [name for name in CASES if (FULL / f"{name}.json.gz").is_file()]
    if not names:
        pytest.skip(f"no recorded results at HUNAV_REFERENCE ({FULL})")
    for name in names:
        expected = reduce(name, read_full(name))
        assert json.loads(read_compact(name)) == expected, name
