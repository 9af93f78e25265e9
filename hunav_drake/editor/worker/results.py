"""The folder with the files of runs, and access to them."""

from collections.abc import Iterable
from pathlib import Path
import secrets
import tempfile
from typing import Any

from hunav_drake.editor.worker.requests import Run

# The files of a run that a page may request, and their types.
FILES = {
    "report.html": "text/html; charset=utf-8",
    "replay.html": "text/html; charset=utf-8",
    "steps.csv": "text/csv; charset=utf-8",
}
_URLS = {
    "report_url": "report.html",
    "replay_url": "replay.html",
    "csv_url": "steps.csv",
}


class ResultFolder:
    """A folder of results, and the addresses of the files in it.

    Attributes:
        given: The folder that the user has chosen, or None.
        token: A secret in the addresses of files, which other pages cannot
            guess.
    """

    def __init__(self, out: str | Path | None) -> None:
        """Constructs it; without `out` the folder is temporary."""
        self.given = None if out is None else Path(out)
        self.token = secrets.token_urlsafe(16)
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._runs: dict[int, Run] = {}

    @property
    def path(self) -> Path:
        """The folder; a temporary one is created on first access."""
        if self.given is not None:
            return self.given
        if self._temporary is None:
            self._temporary = tempfile.TemporaryDirectory(
                prefix="hunav_edit_", ignore_cleanup_errors=True
            )
        return Path(self._temporary.name)

    def add(self, runs: Iterable[Run]) -> None:
        """Adds runs, whose files exist once they have a folder."""
        self._runs |= {run.number: run for run in runs}

    def file(self, token: str, run: str | int, name: str) -> Path | None:
        """Returns the file of an address, or None.

        Only files in `FILES` of finished runs are accessible.

        Args:
            token: The first part of the address.
            run: The number of the run, the second part.
            name: The name of the file, the last part.
        """
        if not secrets.compare_digest(token.encode(), self.token.encode()):
            return None
        if name not in FILES or not str(run).isdecimal() or len(str(run)) > 18:
            return None
        known = self._runs.get(int(run))
        if known is None or known.folder is None:
            return None
        path = known.folder / name
        return path if path.is_file() else None

    def urls(self, run: Run) -> dict[str, Any]:
        """Returns the addresses of the files of a run, relative to the page."""
        return {
            key: f"results/{self.token}/{run.number}/{name}"
            if self.file(self.token, run.number, name)
            else None
            for key, name in _URLS.items()
        }

    def folders(self) -> list[Path]:
        """Returns the folders of all finished runs, in order."""
        runs = self._runs.values()
        return [run.folder for run in runs if run.folder is not None]

    def close(self) -> None:
        """Removes a temporary folder."""
        self._runs.clear()
        if self._temporary is not None:
            self._temporary.cleanup()
            self._temporary = None
