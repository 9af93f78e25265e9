"""The edited scenario, and the messages to its views."""

from collections.abc import Callable, Sequence
import functools
from pathlib import Path
import threading
from typing import Any

from hunav_drake.editor.background import Background, map_background
from hunav_drake.editor.document.document import Document
from hunav_drake.editor.document.outlines import pictures
from hunav_drake.editor.document.steps import Step
from hunav_drake.editor.document.text_patch import difference
from hunav_drake.editor.faults import DEFERRED, message_of
from hunav_drake.editor.files import SessionFile
from hunav_drake.editor.state import State
from hunav_drake.editor.tracing import is_traced
from hunav_drake.scenario.error import Finding, Loc, ScenarioError
from hunav_drake.scenario.json_schema import scenario_json_schema
from hunav_drake.scenario.old_words import find_old_words, renewed_text
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.templates import list_templates
from hunav_drake.scenario.writer import SaveScenario, plain
from hunav_drake.scenarios import shipped_names
from hunav_drake.systems.common.choice_loading import (
    UnloadedChoice,
    registered_only,
)
from hunav_drake.systems.common.old_words import TAG
from hunav_drake.systems.robot.drives import DRIVES
from hunav_drake.systems.robot.robot_config import ROBOTS
from hunav_drake.systems.sensing.sensor_config import SENSORS
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import WALLS

Callback = Callable[[dict[str, Any]], None]

# Messages of the worker that views get unchanged.
_PASSED_ON = ("worker", "runs", "frame", "result", "summary")

# The choices that are known without loading deferred ones.
_CHOICES = (WALLS, FURNITURE, ROBOTS, DRIVES, SENSORS)


class EditedScenario:
    """The text, the data and the faults of an edited scenario.

    Subscribers get its messages. Its parts are `state` and `background`.
    """

    def __init__(
        self,
        text: str | None = None,
        *,
        scenario: Scenario | None = None,
        filename: str | Path | None = None,
        folder: str | Path | None = None,
        imports: Sequence[str] = (),
        worker: Any = None,
        scenario_name: str | None = None,
    ) -> None:
        """Starts with a text, a scenario or a file; by default an empty text.

        Args:
            text: The text of a scenario.
            scenario: A scenario, which is not changed.
            filename: The file, which is read unless there is a text. It need
                not exist yet.
            folder: The folder in which files can be read and written; by
                default that of the file, or the current one.
            imports: Modules that were imported for the scenario.
            worker: The worker that checks names and runs trials, if any.
            scenario_name: The name of the scenario, if the file has several.

        Raises:
            ValueError: If the file cannot be read.
        """
        self._lock = threading.RLock()
        self._callbacks: list[Callback] = []
        self._catalog: dict[str, Any] = {}
        self._ticket: tuple[Any, Any] = (None, None)
        self.imports = tuple(imports)
        self.worker = worker
        self.background: Background | None = None
        file = SessionFile(
            None if filename is None else Path(filename),
            None if folder is None else Path(folder),
        )
        saved = ""
        if file.path is not None and file.path.exists():
            saved = file.read()
        if scenario is not None:
            text = SaveScenario(scenario)
        if text is None:
            text = saved
        elif file.path is None:
            saved = text
        prefix: Loc = () if scenario_name is None else (scenario_name,)
        self.state = State(Document.read(text, prefix), file, saved)
        self.renew()
        self.state.look()
        if worker is not None:
            worker.listen(self._hear)
        self._check_names()

    @property
    def text(self) -> str:
        """The YAML text."""
        return self.state.document.text

    @property
    def data(self) -> Any:
        """The scenario as plain data, which is immutable."""
        return self.state.document.data

    @property
    def faults(self) -> list[dict[str, Any]]:
        """Its faults, in the form of the message ``faults``."""
        with self._lock:
            return self.all_faults()

    @property
    def scenario(self) -> Scenario:
        """The scenario, after all checks.

        Raises:
            ScenarioError: If it has faults.
        """
        with self._lock:
            return self.state.scenario()

    def subscribe(self, callback: Callback) -> Callable[[], None]:
        """Sends all messages to a function; returns a function to end this."""
        with self._lock:
            self._callbacks.append(callback)

        def unsubscribe() -> None:
            with self._lock:
                if callback in self._callbacks:
                    self._callbacks.remove(callback)

        return unsubscribe

    def save(self, filename: str | Path | None = None) -> None:
        """Writes the file.

        Args:
            filename: The file, in any folder; by default the one that was
                opened or saved last.

        Raises:
            ValueError: If it cannot be written.
        """
        with self._lock:
            path = None if filename is None else Path(filename)
            self.state.file.write(self.text, path)
            self.state.saved = self.text
            self.send("saved", filename=str(self.state.file.path))
            self.send_state(None, self.data)

    def set_map(self, filename: str | Path) -> None:
        """Sets a map of ROS 2 as background.

        Raises:
            ValueError: If it cannot be read.
        """
        with self._lock:
            self.set_background(map_background(filename))

    def set_background(
        self, background: Background | None, number: Any = None
    ) -> None:
        """Sets the background, or removes it, and sends it."""
        self.background = background
        content = (
            {"image": None} if background is None else background.message()
        )
        self.send("background", number, **content)
        self.send_faults()

    def close(self) -> None:
        """Ends the session, and its worker."""
        if self.worker is not None:
            self.worker.close()

    def replace(self, number: Any, label: str, text: str) -> None:
        """Replaces the text, as one step."""
        old = self.state.document
        self.take(number, label, Document.read(text, old.prefix, old))
        self.renew()

    def renew(self) -> None:
        """Replaces old words by new ones, as one step, and sends a note."""
        old = self.state.document
        if next(find_old_words(old.data), None) is None:
            return
        content = self.text.encode("utf-8", "surrogatepass")
        try:
            content, words = renewed_text(content, "scenario")
        except ScenarioError:
            # The faults list the remaining ones.
            return
        told = ", ".join(map(repr, words))
        label = f"Write {TAG!r} for {told}"
        new = Document.read(content.decode(), old.prefix, old)
        self.take(None, label, new)
        message = f"the text has old words: {told} is now {TAG!r}; save it"
        self.send("note", message=message)

    def take(
        self, number: Any, label: str, document: Document, key: Any = None
    ) -> None:
        """Replaces the document, as one step, and sends it.

        Args:
            number: The id of the message that caused it.
            label: The label of the step.
            document: The new document.
            key: Steps with the same key shortly after each other are merged.
        """
        state, old = self.state, self.state.document
        patches = difference(old.text, document.text)
        state.document = document
        state.revision += 1
        state.look()
        step = Step(label, patches, old.data, document.data, key)
        state.steps.add(step, document.text)
        self.tell(number, old.data)

    def tell(self, number: Any, before: Any) -> None:
        """Sends the state, the faults and the text."""
        self.send_state(number, before)
        self.send_faults(number)
        self.send_text(number)
        self._check_names()

    def send(self, kind: str, number: Any = None, **content: Any) -> None:
        """Sends a message to all views."""
        message = {"kind": kind, **content}
        if number is not None:
            message["id"] = number
        for callback in list(self._callbacks):
            callback(message)

    def send_state(self, number: Any, before: Any) -> None:
        """Sends the changes of the state, or all of it without `before`."""
        self.send("state", number, **self.state.state(before))

    def send_faults(self, number: Any = None) -> None:
        """Sends the faults."""
        state = self.state
        faults = self.all_faults()
        self.send("faults", number, revision=state.revision, faults=faults)

    def all_faults(self) -> list[dict[str, Any]]:
        """Returns the faults, and that the background has no walls yet."""
        state, background = self.state, self.background
        result = state.faults()
        if background is None or state.document.problem:
            return result
        if is_traced(background, state.wall_points()):
            return result
        remedy = "trace its walls"
        if not background.is_map:
            remedy = f"set its scale, then {remedy}"
        found = Finding(
            ("world", "walls"),
            f"{background.name} is only a picture so far, and everybody walks"
            f" through it; {remedy}",
        )
        told = message_of(found, self.data, severity="warning")
        fix = {"label": "Trace walls", "do": "trace"}
        return [*result, {**told, "fix": fix}]

    def send_text(self, number: Any) -> None:
        """Sends the text, and the lines of selectable parts."""
        state = self.state
        self.send(
            "text",
            number,
            revision=state.revision,
            text=self.text,
            places=[
                [list(loc), first, last]
                for loc, first, last in state.document.places()
            ],
        )

    def send_catalog(self, number: Any = None) -> None:
        """Sends the choices."""
        if not self._catalog:
            self._catalog = {
                "schema": _form_schema(*map(tuple, _CHOICES)),
                "defaults": _form_defaults(),
                "behaviors": [],
                "planners": [],
                "models": [],
                "robots": [],
                "metrics": [],
                "templates": [
                    {"name": name, "title": name.capitalize(), "help": text}
                    for name, text in list_templates().items()
                ],
                "examples": shipped_names(),
                "furniture": pictures(),
                "ready": False,
            }
        self.send("catalog", number, **self._catalog)

    def _check_names(self) -> None:
        """Requests the checks of the worker."""
        document = self.state.document
        if self.worker is None or document.problem:
            return
        name = document.prefix[0] if document.prefix else None
        ticket = self.worker.check(
            "{}" if document.is_empty else document.text,
            str(self.state.file.folder),
            name,
        )
        self._ticket = ticket, document.data

    def _hear(self, message: dict[str, Any]) -> None:
        """Handles a message of the worker."""
        with self._lock:
            kind = message.get("kind")
            content = {key: it for key, it in message.items() if key != "kind"}
            if kind == "checked":
                self._take_checked(content)
            elif kind == "catalog":
                if not self._catalog:
                    self.send_catalog()
                self._catalog = {**self._catalog, **content}
                self.send_catalog()
            elif kind in _PASSED_ON:
                self.send(str(kind), content.pop("id", None), **content)

    def _take_checked(self, content: dict[str, Any]) -> None:
        ticket, data = self._ticket
        if content.get("ticket") != ticket:
            return
        state = self.state
        state.checked_data = data
        state.checked = [
            (
                Finding(
                    tuple(fault["path"]),
                    fault["message"],
                    tuple(tuple(loc) for loc in fault.get("uses", ())),
                ),
                fault.get("severity", "error"),
            )
            for fault in content["faults"]
        ]
        drawn = content.get("drawn", {"people": []})
        if drawn["people"] or state.drawn["people"]:
            state.drawn = drawn
            self.send("drawn", **drawn)
        models = content.get("models", {})
        if models != state.models:
            state.models = models
            self.send_state(None, self.data)
        self.send_faults()


@functools.cache
def _form_schema(*choices: tuple[str, ...]) -> dict[str, Any]:
    """Returns the schema of forms; `choices` are the keys of its cache."""
    del choices
    with registered_only(*DEFERRED):
        return scenario_json_schema()


def _form_defaults() -> dict[str, Any]:
    """Returns the default scenario as plain data."""
    with registered_only(*DEFERRED):
        result: dict[str, Any] = _named(plain(Scenario()))
    return result


def _named(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _named(item) for key, item in data.items()}
    if isinstance(data, list):
        return [_named(item) for item in data]
    if isinstance(data, UnloadedChoice):
        return {key: plain(item) for key, item in data.as_data().items()}
    return data
