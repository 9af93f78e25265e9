"""The file of a session: reading, writing, and detecting changes."""

import hashlib
import os
from pathlib import Path

from hunav_drake.scenario.error import shown
from hunav_drake.scenario.yaml_source import MAX_BYTES
from hunav_drake.systems.common.files import atomic_write

_BOM = b"\xef\xbb\xbf"
_SUFFIXES = (".yaml", ".yml")


class FileRefusedError(ValueError):
    """A file cannot be read or written; the text says why."""


class SessionFile:
    """The file that a session edits, and the folder of its files."""

    def __init__(
        self, path: Path | None = None, folder: Path | None = None
    ) -> None:
        """Constructs it.

        Args:
            path: The file, if there is one; it need not exist yet.
            folder: The folder that other files must be in; by default that of
                the file, or the current one.
        """
        self.path = None if path is None else path.resolve()
        if folder is None:
            folder = self.path.parent if self.path else Path.cwd()
        self.folder = folder.resolve()
        self._bom = b""
        self._stamp: tuple[int, int] | None = None
        self._told: tuple[int, int] | None = None
        self._digest = b""

    def resolve(self, name: str) -> Path:
        """Returns the path of a file name in the folder.

        Raises:
            FileRefusedError: If it is outside the folder, or not YAML.
        """
        if "\0" in name:
            raise FileRefusedError("a file name cannot have null characters")
        try:
            path = (self.folder / name).resolve()
            is_inside = path.is_relative_to(self.folder)
            exists = path.exists()
        except (OSError, RuntimeError) as error:
            words = getattr(error, "strerror", None) or "is not a file name"
            raise FileRefusedError(f"{shown(name)}: {words}") from error
        if not is_inside:
            raise FileRefusedError(
                f"{shown(name)} is outside the folder {self.folder}; choose a"
                " name in it"
            )
        if not path.suffix and not exists:
            path = path.with_name(f"{path.name}.yaml")
        if path.suffix.lower() not in _SUFFIXES:
            raise FileRefusedError(
                f"{shown(name)} is not the name of a scenario file; it must end"
                " in .yaml"
            )
        return path

    def read(self) -> str:
        """Reads the file.

        Raises:
            FileRefusedError: If it cannot be read.
        """
        if self.path is None:
            raise FileRefusedError("there is no file yet; save it first")
        content = _content(self.path)
        text = decoded(content, str(self.path))
        self._bom = _BOM if content.startswith(_BOM) else b""
        self._remember(content)
        return text

    def write(self, text: str, path: Path | None = None) -> None:
        """Writes the file, or another one, which becomes the session's file.

        Raises:
            FileRefusedError: If it cannot be written.
        """
        path = path or self.path
        if path is None:
            raise FileRefusedError("give the scenario a file name to save it")
        content = self._bom + text.encode()
        try:
            with atomic_write(path) as file:
                file.write(content)
        except OSError as error:
            raise FileRefusedError(
                f"{path} cannot be written: {error.strerror or error}"
            ) from error
        self.path = path.resolve()
        self._remember(content)

    def changed(self) -> bool:
        """Returns whether another program has changed the file since."""
        if self.path is None or self._stamp == self._now():
            return False
        try:
            content = _content(self.path)
        except FileRefusedError:
            # Without a readable file, nothing can be overwritten.
            return False
        if hashlib.sha256(content).digest() == self._digest:
            self._stamp = self._now()
            return False
        return True

    def is_news(self) -> bool:
        """Returns, once, whether another program has changed the file."""
        now = self._now()
        if now == self._told or not self.changed():
            return False
        self._told = now
        return True

    def _remember(self, content: bytes) -> None:
        self._digest = hashlib.sha256(content).digest()
        self._stamp = self._now()

    def _now(self) -> tuple[int, int] | None:
        try:
            status = os.stat(self.path or "")
        except OSError:
            return None
        return status.st_mtime_ns, status.st_size


def decoded(content: bytes, name: str) -> str:
    """Returns UTF-8 bytes as text, without a byte order mark.

    Raises:
        FileRefusedError: If they are not UTF-8.
    """
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileRefusedError(
            f"{name} is not UTF-8 text: byte 0x{content[error.start]:02x} at"
            f" offset {error.start}"
        ) from error


def _content(path: Path) -> bytes:
    try:
        if not path.is_file():
            raise FileRefusedError(f"there is no file {path}")
        if path.stat().st_size > MAX_BYTES:
            raise FileRefusedError(
                f"{path} is too large: at most {MAX_BYTES} bytes"
            )
        return path.read_bytes()
    except OSError as error:
        raise FileRefusedError(
            f"{path} cannot be read: {error.strerror or error}"
        ) from error
