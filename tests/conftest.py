from pathlib import Path
import shutil

import pytest

from tests.recorded import FULL

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")


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


@pytest.fixture(scope="session")
def browser():
    """A headless browser, one for all tests of a process."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="there is no Playwright"
    )
    if BROWSER is None:
        pytest.skip("there is no Chromium on this machine")
    with playwright.sync_playwright() as start:
        found = start.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox"]
        )
        yield found
        found.close()
