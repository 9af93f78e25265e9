from pathlib import Path

import pytest

from tests.recorded import FULL


@pytest.fixture(scope="session")
def reference() -> Path:
    """The folder with the original's own files, which are not in `data`."""
    if not FULL.is_dir():
        pytest.skip(f"no files of the original at HUNAV_REFERENCE ({FULL})")
    return FULL


@pytest.fixture
def restored_metrics():
    """The registered metrics, as they are again after the test."""
    from hunav_drake.systems.evaluation.metrics import METRICS

    before = dict(METRICS)
    yield METRICS
    METRICS.clear()
    METRICS.update(before)
