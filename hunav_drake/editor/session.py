"""A session of editing one scenario, without a page: messages in and out."""

from collections.abc import Callable, Sequence
from pathlib import Path
import threading
from typing import Any

from hunav_drake.editor.document.outlines import Outlines
from hunav_drake.editor.document.plain_data import (
    OperationError,
    apply,
    changes,
    check_plain,
    jsonable,
    shared,
)
from hunav_drake.editor.document.steps import Step, Steps
from hunav_drake.editor.document.text_patch import Patches, difference, patched
from hunav_drake.editor.document.yaml_patch import patch_yaml
from hunav_drake.editor.faults import find_faults, message_of
from hunav_drake.editor.forms import form_defaults, form_schema
from hunav_drake.editor.messages import (
    AnyMessage,
    Edit,
    Hello,
    MessageError,
    Preview,
    Redo,
    Save,
    TypedText,
    Undo,
    id_of,
    read_message,
)
from hunav_drake.scenario.error import Finding, Loc
from hunav_drake.scenario.loading import LoadScenario
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import SaveScenario
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import parse_yaml

Callback = Callable[[dict[str, Any]], None]


class EditSession:
    """The text, the data and the faults of a scenario that is edited."""

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
        """Starts with a text, a scenario or a file; by default, with nothing.

        Args:
            text: The text of a scenario.
            scenario: A scenario that was made in Python; it stays as it is.
            filename: The file, which is read unless there is a text.
            folder: Where files may be read and written; by default that of
                the file, or the present one.
            imports: Modules that the worker imports.
            worker: What checks names and runs trials; None for nothing.
            scenario_name: Which scenario of a file of several.
        """
        self._lock = threading.RLock()
        self._callbacks: list[Callback] = []
        self._filename = None if filename is None else Path(filename).resolve()
        self._imports = tuple(imports)
        self._worker = worker
        self._prefix: Loc = () if scenario_name is None else (scenario_name,)
        self._outlines = Outlines()
        self._revision = 0
        self._steps = Steps()
        if scenario is not None:
            text = SaveScenario(scenario)
        if text is None:
            text = ""
            if self._filename is not None and self._filename.exists():
                text = self._filename.read_text(encoding="utf-8")
        self._text = text
        self._saved = text
        self._data: Any = {}
        self._document = YamlDocument("data")
        self._findings: list[Finding] = []
        self._read_text()
        self._shown_outlines = self._outlines.of(self._data.get("world"))

    @property
    def text(self) -> str:
        """The YAML text."""
        return self._text

    @property
    def data(self) -> Any:
        """The scenario as plain data; parts of it never change."""
        return self._data

    @property
    def faults(self) -> list[dict[str, Any]]:
        """What is wrong with it, in the form of the message ``faults``."""
        with self._lock:
            return self._faults()

    @property
    def scenario(self) -> Scenario:
        """The scenario.

        Raises:
            ScenarioError: While it has faults.
        """
        with self._lock:
            name = self._prefix[0] if self._prefix else None
            return LoadScenario(
                data=self._text or "{}", scenario_name=name and str(name)
            )

    def subscribe(self, callback: Callback) -> Callable[[], None]:
        """Sends all messages to a function; returns what ends that."""
        with self._lock:
            self._callbacks.append(callback)

        def unsubscribe() -> None:
            with self._lock:
                if callback in self._callbacks:
                    self._callbacks.remove(callback)

        return unsubscribe

    def receive(self, message: Any) -> None:
        """Does what a message says; whatever it is, it is answered."""
        with self._lock:
            number = id_of(message)
            try:
                self._handle(read_message(message))
            except (MessageError, OperationError) as error:
                self._send("error", number, message=str(error))

    def save(self, filename: str | Path | None = None) -> None:
        """Writes the file."""
        with self._lock:
            path = Path(filename).resolve() if filename else self._filename
            if path is None:
                raise ValueError("give a file name to save it")
            path.write_text(self._text, encoding="utf-8")
            self._filename = path
            self._saved = self._text

    def close(self) -> None:
        """Ends the session, and its worker."""
        if self._worker is not None:
            self._worker.close()

    def _handle(self, message: AnyMessage) -> None:
        if isinstance(message, Hello):
            self._send_catalog(message.id)
            self._send_state(message.id, None)
            self._send_faults(message.id)
            self._send_text(message.id)
        elif isinstance(message, Edit):
            self._edit(message)
        elif isinstance(message, Preview):
            self._preview(message)
        elif isinstance(message, TypedText):
            self._type(message)
        elif isinstance(message, Undo | Redo):
            self._step_back(message)
        elif isinstance(message, Save):
            self.save(message.filename)
            self._send("saved", message.id, filename=str(self._filename))
            self._send_state(message.id, self._data)
        else:
            raise MessageError(f"{message.do!r} is not there yet")

    def _edit(self, message: Edit) -> None:
        if not self._is_present(message):
            return
        if self._document.root is None and self._text.strip():
            raise OperationError(
                "the text does not read as YAML; mend it first"
            )
        new = self._applied(message.ops)
        before = self._data
        paths = tuple(repr(op[1]) for op in message.ops if op[0] == "set")
        key = (message.label, paths) if len(paths) == len(message.ops) else None
        self._set_data(new)
        self._send_state(message.id, before)
        self._send_faults(message.id)
        patches, _ = patch_yaml(
            self._text, before, new, self._prefix, self._document
        )
        self._text = patched(self._text, patches)
        self._document = parse_yaml(self._text, name="data")
        self._steps.add(
            Step(message.label, patches, before, new, key), self._text
        )
        self._send_text(message.id)
        self._send_state(message.id, new)
        if self._findings:
            self._send_faults(message.id)

    def _preview(self, message: Preview) -> None:
        if not self._is_present(message):
            return
        new = self._applied(message.ops)
        findings = find_faults(new)
        self._send(
            "faults",
            message.id,
            revision=self._revision,
            preview=message.id,
            faults=[message_of(found) for found in findings],
        )

    def _type(self, message: TypedText) -> None:
        if not self._is_present(message):
            return
        before = self._data
        patches: Patches = difference(self._text, message.text)
        self._text = message.text
        self._read_text()
        self._revision += 1
        self._steps.add(
            Step("Typing", patches, before, self._data, "typing"), self._text
        )
        self._send_state(message.id, before)
        self._send_faults(message.id)
        self._send_text(message.id)

    def _step_back(self, message: Undo | Redo) -> None:
        is_undo = isinstance(message, Undo)
        move = self._steps.undo if is_undo else self._steps.redo
        found = move(self._text)
        if found is None:
            word = "undone" if is_undo else "done again"
            raise OperationError(f"there is nothing to be {word}")
        before = self._data
        self._text, data = found
        self._read_text(data)
        self._revision += 1
        self._send_state(message.id, before)
        self._send_faults(message.id)
        self._send_text(message.id)

    def _applied(self, ops: Sequence[Any]) -> Any:
        for operation in ops:
            for value in operation[2:]:
                check_plain(value)
        new = apply(self._data, ops)
        if not isinstance(new, dict):
            raise OperationError("a scenario is a mapping")
        return new

    def _is_present(self, message: Edit | Preview | TypedText) -> bool:
        """Answers with the state if a message is about an earlier one."""
        if message.base == self._revision:
            return True
        self._send_state(message.id, None)
        if not isinstance(message, Preview):
            self._send_text(message.id)
        return False

    def _read_text(self, data: Any = None) -> None:
        """Takes over what the text says, if it can be read."""
        self._document = parse_yaml(self._text, name="data")
        if data is None:
            data = self._document.plain(self._prefix)
            if not self._text.strip():
                data = {}
        if isinstance(data, dict):
            self._set_data(shared(self._data, data), count=False)

    def _set_data(self, data: Any, *, count: bool = True) -> None:
        self._data = data
        self._revision += count
        known = [found.loc for _, found in self._document.findings]
        self._findings = find_faults(data, [loc for loc in known if loc])

    def _faults(self) -> list[dict[str, Any]]:
        document = self._document
        size = len(self._prefix)
        result = []
        if self._text.strip():
            for line, found in document.findings:
                inner = Finding(found.loc[size:], found.message)
                result.append({**message_of(inner), "line": line or None})
        if document.root is None and self._text.strip():
            return result
        return result + [
            message_of(found, document, self._prefix)
            for found in self._findings
        ]

    def _send_state(self, number: Any, before: Any) -> None:
        """Tells the state; all of it unless it is known what was before."""
        outlines = self._outlines.of(self._data.get("world"))
        is_new = before is None or outlines != self._shown_outlines
        self._shown_outlines = outlines
        found = [((), self._data)]
        if before is not None:
            found = changes(before, self._data)
        name = self._data.get("name") or (
            self._filename.stem if self._filename else ""
        )
        self._send(
            "state",
            number,
            revision=self._revision,
            changes=[[list(loc), jsonable(value)] for loc, value in found],
            outlines=outlines if is_new else None,
            undo=self._steps.undo_label,
            redo=self._steps.redo_label,
            dirty=self._text != self._saved,
            name=name if isinstance(name, str) else "",
            filename=str(self._filename) if self._filename else None,
            readable=self._document.root is not None or not self._text.strip(),
        )

    def _send_faults(self, number: Any) -> None:
        self._send(
            "faults", number, revision=self._revision, faults=self._faults()
        )

    def _send_text(self, number: Any) -> None:
        self._send("text", number, revision=self._revision, text=self._text)

    def _send_catalog(self, number: Any) -> None:
        self._send(
            "catalog",
            number,
            schema=form_schema(),
            defaults=form_defaults(),
            behaviors=[],
            planners=[],
            models=[],
            robots=[],
            metrics=[],
            templates=[],
            examples=[],
            ready=False,
        )

    def _send(self, kind: str, number: Any = None, **content: Any) -> None:
        message = {"kind": kind, **content}
        if number is not None:
            message["id"] = number
        for callback in list(self._callbacks):
            callback(message)
