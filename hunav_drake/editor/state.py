"""The state of a session, and its messages to views."""

from collections.abc import Mapping, Sequence
import copy
import dataclasses as dc
import itertools
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from hunav_drake.editor.document.document import Document
from hunav_drake.editor.document.outlines import Outline, Outlines
from hunav_drake.editor.document.plain_data import changes, get, jsonable
from hunav_drake.editor.document.steps import Steps
from hunav_drake.editor.faults import find_faults, inside, message_of
from hunav_drake.editor.files import SessionFile
from hunav_drake.scenario.building import (
    Places,
    build_scenario,
    document_faults,
)
from hunav_drake.scenario.checks import ALL_CHECKS
from hunav_drake.scenario.error import Fault, Finding, ScenarioError
from hunav_drake.scenario.file_paths import find_files
from hunav_drake.scenario.old_words import find_old_words
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.common.old_words import TAG
from hunav_drake.systems.world.maps.map_file import map_outlines
from hunav_drake.systems.world.solids import WorldFileError

# The maximum number of warnings about old words.
_MAX_OLD = 50


@dc.dataclass
class State:
    """The document of a session, with its file and its history.

    Attributes:
        document: The text and the data.
        file: The file.
        saved: The text in the file.
        revision: The number of changes.
        steps: The steps to undo and redo.
    """

    document: Document
    file: SessionFile
    saved: str
    revision: int = 0
    steps: Steps = dc.field(default_factory=Steps)

    def __post_init__(self) -> None:
        self._outlines = Outlines()
        self._told: dict[str, Outline] | None = None
        self.findings: list[Finding] = []
        # The findings of the worker with their severity, and the data that it
        # checked.
        self.checked: list[tuple[Finding, str]] = []
        self.checked_data: Any = None
        # The people whom a seed draws, from the worker.
        self.drawn: dict[str, Any] = {"people": []}
        # The outlines of models by file, from the worker.
        self.models: Mapping[str, Sequence[ArrayLike]] = {}

    @property
    def is_dirty(self) -> bool:
        """Whether there are unsaved changes."""
        return self.document.text != self.saved

    def look(self) -> None:
        """Checks the current data."""
        document = self.document
        size = len(document.prefix)
        known = [
            found.loc[size:]
            for _, found in document.yaml.findings
            if found.loc[size:]
        ]
        self.findings = find_faults(document.data, known, self.file.folder)

    def state(self, before: Any) -> dict[str, Any]:
        """Returns the content of the message ``state``.

        Args:
            before: The data that views have; None if they have none.
        """
        document, data = self.document, self.document.data
        outlines = self._all_outlines()
        is_new = before is None or outlines != self._told
        self._told = outlines
        found = [((), data)] if before is None else changes(before, data)
        return {
            "revision": self.revision,
            "changes": [[list(loc), jsonable(value)] for loc, value in found],
            "outlines": outlines if is_new else None,
            "undo": self.steps.undo_label,
            "redo": self.steps.redo_label,
            "dirty": self.is_dirty,
            "name": self.name(),
            "filename": str(self.file.path) if self.file.path else None,
            "readable": not document.problem,
        }

    def name(self) -> str:
        """Returns the name of the scenario, by default that of its file."""
        name = self.document.data.get("name")
        if not isinstance(name, str) or not name:
            name = self.file.path.stem if self.file.path else ""
        return name

    def faults(self) -> list[dict[str, Any]]:
        """Returns the faults, in the form of the message ``faults``."""
        document, data = self.document, self.document.data
        size = len(document.prefix)
        result = []
        if not document.is_empty:
            for line, found in document.yaml.findings:
                inner = Finding(found.loc[size:], found.message)
                result.append(message_of(inner, data, line or None))
        if document.problem:
            if not result:
                found = Finding((), document.problem)
                result.append(message_of(found, data, 1))
            return result
        checked = self._still_checked()
        told = {found.loc for found, _ in checked}
        # The worker knows more of a place than the fast checks.
        fast = [(it, "error") for it in self.findings if it.loc not in told]
        for found, severity in [*fast, *checked]:
            at = document.line(found.loc)
            result.append(message_of(found, data, at, severity))
        return [*result, *self._warnings()]

    def scenario(self) -> Scenario:
        """Returns the scenario, after all checks.

        Raises:
            ScenarioError: If it has faults.
        """
        document = self.document
        faults = document_faults(document.yaml, document.prefix)
        if document.is_empty:
            faults = []
        elif document.problem and not faults:
            faults = [Fault("scenario", 1, "", document.problem)]
        if document.problem:
            raise ScenarioError("scenario", faults)
        data = copy.deepcopy(document.data)
        find_files(data, self.file.folder)
        with registered_only():
            scenario, findings = build_scenario(data, ALL_CHECKS)
        places = Places(document.yaml, document.prefix)
        faults += [places.fault(found, data) for found in findings]
        if scenario is None or faults:
            raise ScenarioError("scenario", faults)
        return dc.replace(scenario, name=scenario.name or self.name())

    def preview(self, data: Any) -> list[dict[str, Any]]:
        """Returns the faults of other data."""
        found = find_faults(data, folder=self.file.folder)
        return [
            message_of(it, data, self.document.line(it.loc)) for it in found
        ]

    def _still_checked(self) -> list[tuple[Finding, str]]:
        """Returns the worker's findings about parts that did not change."""
        gone = object()
        return [
            (found, severity)
            for found, severity in self.checked
            if all(
                get(self.document.data, loc, gone)
                is get(self.checked_data, loc, gone)
                for loc in (found.loc, *found.uses)
                if loc
            )
        ]

    def _warnings(self) -> list[dict[str, Any]]:
        data = self.document.data
        found = [
            Finding(loc, f"is now {TAG!r}; rename it")
            for loc in itertools.islice(find_old_words(data), _MAX_OLD)
        ]
        name = get(data, ("world", "map"))
        if isinstance(name, str) and name and self._map_path() is None:
            found.append(
                Finding(
                    ("world", "map"),
                    "is not shown: it is outside the folder"
                    f" {self.file.folder}; put the map into it",
                )
            )
        line = self.document.line
        return [message_of(it, data, line(it.loc), "warning") for it in found]

    def _all_outlines(self) -> dict[str, Outline]:
        return self._outlines.of(
            self.document.data, self._map_outlines(), self.models
        )

    def wall_points(self) -> list[Any]:
        """Returns the points of the outlines of all that stands."""
        outlines = self._all_outlines().values()
        return [it["points"] for it in outlines if it["height"] > 0]

    def _map_path(self) -> Path | None:
        name = get(self.document.data, ("world", "map"))
        if not isinstance(name, str) or not name:
            return None
        return inside(self.file.folder, name)

    def _map_outlines(self) -> tuple[Array, ...]:
        path = self._map_path()
        if path is None:
            return ()
        try:
            return map_outlines(path)
        except WorldFileError:
            # The check reports it.
            return ()
