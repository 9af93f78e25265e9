import pytest

from hunav_drake.runs import code_hash
from hunav_drake.runs.code_hash import (
    PACKAGE,
    code_sha256,
    hash_code,
    hash_of_all,
)


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package like ours, one of whose parts is a link."""
    root = tmp_path / "hunav_drake"
    for name in ("scenario", "editor", "runs/comparison"):
        (root / name).mkdir(parents=True)
    systems = tmp_path / "systems"
    systems.mkdir()
    (root / "systems").symlink_to(systems, target_is_directory=True)
    (root / "trial.py").write_text("STEP = 0.01")
    (systems / "crowd.py").write_text("FORCE = 2.1")
    monkeypatch.setattr(code_hash, "_ROOT", root)
    return root


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("trial.py", True),
        ("systems/crowd.py", True),
        ("systems/tree.xml", True),
        ("scenario/new.py", True),
        ("editor/page.py", False),
        ("runs/comparison/tables.py", False),
        ("systems/crowd.cpython-312.pyc", False),
        ("readme.md", False),
    ],
)
def test_what_runs_follow_from_counts(package, name, counts):
    before = code_sha256(PACKAGE)
    (package / name).write_text("changed")
    assert (code_sha256(PACKAGE) != before) is counts


def test_where_code_lies_does_not_count(tmp_path):
    files = []
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
        files.append(str(tmp_path / folder / "mine.py"))
        (tmp_path / folder / "mine.py").write_text("SPEED = 1.0")
    assert code_sha256(files[0]) == code_sha256(files[1])
    assert hash_of_all(hash_code(files[:1])) == hash_of_all(
        hash_code(files[1:])
    )
    assert hash_of_all(hash_code(files)) != hash_of_all(hash_code())


def test_a_package_of_the_user_counts_as_a_whole(tmp_path, monkeypatch):
    folder = tmp_path / "crowd_of_mine"
    (folder / "inner").mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    before = code_sha256("crowd_of_mine")
    (folder / "inner" / "planner.py").write_text("SPEED = 1.0")
    assert code_sha256("crowd_of_mine") != before


def test_what_is_not_there_is_told(tmp_path):
    with pytest.raises(ModuleNotFoundError, match="'no_such_module'"):
        hash_code(["no_such_module"])
    with pytest.raises(FileNotFoundError, match=r"nowhere\.py"):
        hash_code([str(tmp_path / "nowhere.py")])
