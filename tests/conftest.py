from pathlib import Path
import shutil
import subprocess
import sys
import zipfile

from hypothesis import HealthCheck, settings
import pytest

from tests.recorded import FULL

ROOT = Path(__file__).resolve().parents[1]

# No test fails on a slow machine. `pytest --hypothesis-profile thorough` draws
# more.
settings.register_profile(
    "fast",
    max_examples=50,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "thorough", settings.get_profile("fast"), max_examples=1000
)
settings.load_profile("fast")

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


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """The wheel, built from the source distribution alone."""
    # A build writes into its source folder: two workers need two of them.
    folder = tmp_path_factory.mktemp("wheel")
    source = shutil.copytree(
        ROOT,
        folder / "source",
        symlinks=True,
        ignore=shutil.ignore_patterns(
            ".*", "build", "dist", "out", "*.egg-info", "__pycache__"
        ),
    )
    built = subprocess.run(
        [sys.executable, "-m", "build", "--outdir", folder, source],
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    assert list(folder.glob("*.tar.gz"))
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="session")
def installed(wheel):
    """A folder for PYTHONPATH with what is in the wheel.

    Beside it is the compiled code of the same sources, which is not compiled
    again.
    """
    folder = wheel.parent / "installed"
    zipfile.ZipFile(wheel).extractall(folder)
    for kept in (
        *(ROOT / "systems").rglob("__pycache__/*.nb[ic]"),
        *(ROOT / "systems").rglob("__pycache__/kernels.sha256"),
    ):
        copy = folder / "hunav_drake" / kept.relative_to(ROOT)
        copy.parent.mkdir(exist_ok=True)
        shutil.copy2(kept, copy)
    return folder
