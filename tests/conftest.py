import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def reference() -> Path:
    """The recorded results of the original programs."""
    path = Path(
        os.environ.get("HUNAV_REFERENCE", ROOT / "../shared/reference")
    ).resolve()
    if not path.is_dir():
        pytest.skip(f"no recorded results at HUNAV_REFERENCE ({path})")
    return path
