from pathlib import Path

import pytest

from hunav_drake import systems
from hunav_drake.systems.common.kernels import drop_stale_kernels, hash_sources

FOLDER = Path(systems.__file__).parent


def drop(folder, stamp):
    return drop_stale_kernels(hash_sources(folder), folder, stamp)


@pytest.fixture
def sources(tmp_path):
    (tmp_path / "block" / "__pycache__").mkdir(parents=True)
    (tmp_path / "shared.py").write_text(
        "import numba # njit 1\n"
        "from hunav_drake.systems.block.constants import ONE\n"
    )
    (tmp_path / "block" / "constants.py").write_text("ONE = 1")
    (tmp_path / "block" / "plain.py").write_text("pass")
    return tmp_path


def test_a_change_of_one_source_drops_what_all_compiled_to(sources):
    stamp = sources / "__pycache__" / "stamp"
    compiled = sources / "block" / "__pycache__" / "kernel.f-1.py312.1.nbc"
    assert drop(sources, stamp)
    compiled.write_text("code")
    assert not drop(sources, stamp)
    (sources / "block" / "plain.py").write_text("pass # nothing compiled")
    assert not drop(sources, stamp)
    assert compiled.exists()
    (sources / "shared.py").write_text("import numba # njit 2")
    assert drop(sources, stamp)
    assert not compiled.exists()


def test_a_change_of_a_constant_drops_it_too(sources):
    stamp = sources / "__pycache__" / "stamp"
    assert drop(sources, stamp)
    (sources / "block" / "constants.py").write_text("ONE = 2")
    assert drop(sources, stamp)
    assert not drop(sources, stamp)


def test_a_folder_that_cannot_be_written_is_no_error(sources):
    stamp = sources / "shared.py" / "stamp"
    assert drop(sources, stamp)


def test_whatever_is_compiled_imports_the_check_first():
    for path in FOLDER.rglob("*.py"):
        text = path.read_text()
        if "import numba\n" in text or "from numba import" in text:
            checked = "hunav_drake.systems.common.kernels" in text
            assert checked or path.name == "kernels.py", path
