from pathlib import Path

import pytest

from tests.recorded import FULL


@pytest.fixture(scope="session")
def reference() -> Path:
    """The folder with the original's own files, which are not in `data`."""
    if not FULL.is_dir():
        pytest.skip(f"no files of the original at HUNAV_REFERENCE ({FULL})")
    return FULL
