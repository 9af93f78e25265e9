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


@pytest.mark.parametrize("name", CASES)
def test_a_compact_case_is_a_part_of_the_full_one(name):
    if not (FULL / f"{name}.json.gz").is_file():
        pytest.skip(f"no {name} at HUNAV_REFERENCE ({FULL})")
    assert json.loads(read_compact(name)) == reduce(name, read_full(name))
