import errno
import os

import pytest

from hunav_drake.systems.common.files import atomic_write


def test_a_file_appears_when_it_is_complete(tmp_path):
    path = tmp_path / "table.csv"
    with atomic_write(path) as file:
        file.write(b"a")
        assert not path.exists()
    assert path.read_bytes() == b"a"
    assert os.listdir(tmp_path) == ["table.csv"]


def test_a_failure_leaves_what_was_there(tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes(b"old")

    def fail():
        with atomic_write(path) as file:
            file.write(b"new")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["table.csv"]


def test_a_link_stays_one(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "file")
    with atomic_write(tmp_path / "link") as file:
        file.write(b"a")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_bytes() == b"a"


@pytest.mark.parametrize(
    ("name", "error", "words"),
    [
        ("no/table.csv", FileNotFoundError, "No such file"),
        ("file/table.csv", NotADirectoryError, "Not a directory"),
        (".", OSError, "Not a regular file"),
    ],
)
def test_the_error_names_the_file_that_was_given(
    tmp_path, monkeypatch, name, error, words
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(error, match=words) as info, atomic_write(name):
        pass
    assert info.value.filename == name


def test_the_error_of_a_full_disk_names_the_file(tmp_path):
    path = tmp_path / "table.csv"
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with (
        pytest.raises(OSError, match="No space left") as info,
        atomic_write(path),
    ):
        raise full
    assert info.value.filename == str(path)
    assert not os.listdir(tmp_path)


def test_a_device_is_not_replaced():
    with (
        pytest.raises(OSError, match="Not a regular file"),
        atomic_write("/dev/null"),
    ):
        pass
