"""The functions of a session that handle its messages."""

from collections.abc import Callable
import dataclasses as dc
from typing import Any

from hunav_drake.editor.background import (
    BackgroundError,
    checked_place,
    read_background,
)
from hunav_drake.editor.document.document import Document
from hunav_drake.editor.document.plain_data import OperationError
from hunav_drake.editor.document.steps import Step
from hunav_drake.editor.doors import door_operations
from hunav_drake.editor.edited_scenario import EditedScenario
from hunav_drake.editor.files import FileRefusedError, SessionFile
from hunav_drake.editor.imports import imported
from hunav_drake.editor.messages import (
    Door,
    Edit,
    Import,
    Open,
    Preview,
    Reload,
    Request,
    Run,
    Save,
    Trace,
    TypedText,
    UseBackground,
    UseTemplate,
)
from hunav_drake.editor.state import State
from hunav_drake.editor.tracing import traced_walls
from hunav_drake.editor.worker.requests import RunRequest
from hunav_drake.scenario.templates import template_text
from hunav_drake.scenarios import shipped_names, shipped_text
from hunav_drake.systems.common.suggest import counted

# The maximum number of runs of a request.
_MAX_RUNS = 1000


def _hello(session: EditedScenario, message: Request) -> None:
    session.send_catalog(message.id)
    session.send_state(message.id, None)
    session.send_faults(message.id)
    session.send_text(message.id)
    if session.background is not None:
        session.send("background", message.id, **session.background.message())
    if session.state.drawn["people"]:
        session.send("drawn", message.id, **session.state.drawn)
    if session.worker is not None:
        session.worker.repeat()


def _edit(session: EditedScenario, message: Edit) -> None:
    """Changes the data; the text follows."""
    if not _is_present(session, message):
        return
    state = session.state
    data = state.document.after(message.ops)
    _change(session, message.id, message.label, data, _merge_key(message))


def _change(
    session: EditedScenario,
    number: Any,
    label: str,
    data: dict[str, Any],
    key: Any = None,
) -> None:
    """Replaces the data, as one step; views get the data, then the text."""
    state = session.state
    old, findings = state.document, state.findings
    state.document = dc.replace(old, data=data)
    state.revision += 1
    state.look()
    session.send_state(number, old.data)
    session.send_faults(number)
    try:
        new, patch = old.patched(data)
    except OperationError:
        state.document, state.findings = old, findings
        state.revision += 1
        session.send_state(number, data)
        session.send_faults(number)
        raise
    step = Step(label, patch.patches, old.data, data, key)
    state.steps.add(step, new.text)
    state.document = new
    session.tell(number, data)
    if patch.rewritten is not None:
        where = ".".join(map(str, patch.rewritten)) or "the scenario"
        session.send(
            "note",
            number,
            message=f"{where} was rewritten, because it has anchors or an"
            " unusual layout; undo restores the old text",
        )


def _merge_key(message: Edit) -> Any:
    """Returns a key of edits of the same parts, if they only set them."""
    if any(operation[0] != "set" for operation in message.ops):
        return None
    return message.label, tuple(tuple(it[1]) for it in message.ops)


def _preview(session: EditedScenario, message: Preview) -> None:
    if not _is_present(session, message):
        return
    state = session.state
    session.send(
        "faults",
        message.id,
        revision=state.revision,
        preview=message.id,
        faults=state.preview(state.document.after(message.ops)),
    )


def _text(session: EditedScenario, message: TypedText) -> None:
    if not _is_present(session, message):
        return
    old = session.state.document
    document = Document.read(message.text, old.prefix, old)
    session.take(message.id, "Typing", document, "typing")


def _undo_or_redo(session: EditedScenario, message: Request) -> None:
    state, old = session.state, session.state.document
    step = state.steps.undo if message.do == "undo" else state.steps.redo
    found = step(session.text)
    if found is None:
        raise OperationError(f"there is nothing to {message.do}")
    text, data = found
    # The data of the step share parts with the current data.
    like = dc.replace(old, data=data)
    state.document = Document.read(text, old.prefix, like)
    state.revision += 1
    state.look()
    session.tell(message.id, old.data)


def _save(session: EditedScenario, message: Save) -> None:
    """Writes the file; asks first if it would overwrite changes or faults."""
    state, file = session.state, session.state.file
    path = file.path
    if message.filename is not None:
        path = file.resolve(message.filename)
    if path is None:
        raise FileRefusedError("give the scenario a file name to save it")
    if not message.confirm:
        doubts = []
        if path != file.path and path.exists():
            doubts.append(f"{path.name} already exists.")
        elif path == file.path and file.changed():
            doubts.append(f"{path.name} was changed by another program.")
        errors = [it for it in state.faults() if it["severity"] == "error"]
        if errors:
            count = f"{len(errors)} fault{'s' * (len(errors) > 1)}"
            doubts.append(f"The scenario has {count}.")
        if doubts:
            again = {"do": "save", "confirm": True}
            if message.filename is not None:
                again["filename"] = message.filename
            question = " ".join([*doubts, "Save anyway?"])
            session.send("ask", message.id, question=question, again=again)
            return
    file.write(session.text, path)
    state.saved = session.text
    session.send("saved", message.id, filename=str(file.path))
    session.send_state(message.id, session.data)


def _reload(session: EditedScenario, message: Reload) -> None:
    state = session.state
    if state.file.path is None:
        raise FileRefusedError("there is no file yet; save it first")
    if state.is_dirty and not message.confirm:
        question = "Reload the file? Undo restores your changes."
        again = {"do": "reload", "confirm": True}
        session.send("ask", message.id, question=question, again=again)
        return
    text = state.file.read()
    state.saved = text
    session.replace(message.id, "Read the file again", text)


def _open(session: EditedScenario, message: Open) -> None:
    state = session.state
    if state.is_dirty and not message.confirm:
        again = {"do": "open", "filename": message.filename, "confirm": True}
        question = "Open another scenario? Unsaved changes will be lost."
        session.send("ask", message.id, question=question, again=again)
        return
    file = SessionFile(None, state.file.folder)
    path = file.resolve(message.filename)
    if path.exists() or message.filename not in shipped_names():
        file = SessionFile(path, state.file.folder)
        text = file.read()
    else:
        text = shipped_text(message.filename)
    document = Document.read(text)
    session.state = State(document, file, text, state.revision + 1)
    session.state.look()
    session.tell(message.id, None)
    session.renew()


def _template(session: EditedScenario, message: UseTemplate) -> None:
    try:
        text = template_text(message.name)
    except ValueError as error:
        raise OperationError(str(error)) from None
    session.replace(message.id, f"Template {message.name}", text)


def _import(session: EditedScenario, message: Import) -> None:
    document = session.state.document
    if document.problem and message.mode == "add":
        raise OperationError(f"{document.problem}; fix it first")
    found = imported(
        document.data, message.kind, message.mode, message.name, message.text
    )
    label = f"Import {message.name.rpartition('/')[2][:60]}"
    if found.text is not None and not document.prefix:
        session.replace(message.id, label, found.text)
    else:
        data = document.after([("set", (), found.data)])
        _change(session, message.id, label, data)
    if found.notes:
        session.send("notes", message.id, title=label, notes=found.notes)


def _background(session: EditedScenario, message: UseBackground) -> None:
    if message.remove:
        session.set_background(None, message.id)
        return
    if not message.files:
        background = session.background
        place = checked_place(message.width_m, message.origin)
        if background is None or place is None:
            raise BackgroundError("give a map or a picture")
        background = background.placed(*place)
    else:
        background = read_background(message.files, message.name)
    session.set_background(background, message.id)


def _trace(session: EditedScenario, message: Trace) -> None:
    if not _is_present(session, message):
        return
    background = session.background
    if background is None:
        raise BackgroundError("there is no background image to trace")
    if place := checked_place(message.width_m, message.origin):
        background = background.placed(*place)
    walls = traced_walls(background)
    document = session.state.document
    world = document.data.get("world")
    old = world.get("walls") if isinstance(world, dict) else None
    both = [*(old if isinstance(old, list) else []), *walls]
    data = document.after([("set", ("world", "walls"), both)])
    label = f"Trace {counted(len(walls), 'wall')}"
    _change(session, message.id, label, data)


def _door(session: EditedScenario, message: Door) -> None:
    if not _is_present(session, message):
        return
    document = session.state.document
    operations = door_operations(document.data, message.at, message.reach)
    data = document.after(operations)
    _change(session, message.id, "Add a door", data)


def _run(session: EditedScenario, message: Run) -> None:
    state = session.state
    if session.worker is None:
        raise OperationError("trials cannot run here: there is no worker")
    if any(it["severity"] == "error" for it in state.faults()):
        raise OperationError("the scenario has faults; fix them to run it")
    document, file = state.document, state.file
    count = max(len(set(message.seeds)), 1) * max(len(set(message.planners)), 1)
    if count > _MAX_RUNS:
        raise OperationError(
            f"at most {_MAX_RUNS} runs are possible at once, got {count};"
            " choose fewer seeds or planners, or write a suite for `hunav"
            " bench`"
        )
    request = RunRequest(
        text="{}" if document.is_empty else document.text,
        folder=str(file.folder),
        filename=str(file.path) if file.path else None,
        name=str(document.prefix[0]) if document.prefix else None,
        revision=state.revision,
        seeds=message.seeds,
        planners=message.planners,
        speed=message.speed or 0.0,
        workers=message.workers,
    )
    session.worker.run(request, message.id)


def _cancel(session: EditedScenario, message: Request) -> None:
    if session.worker is None:
        raise OperationError("there is nothing to stop")
    session.worker.cancel()


def _is_present(
    session: EditedScenario, message: Edit | Preview | TypedText | Trace | Door
) -> bool:
    """Returns whether a message is about the current revision.

    If not, sends the current state.
    """
    if message.base == session.state.revision:
        return True
    session.send_state(message.id, None)
    if not isinstance(message, Preview):
        session.send_text(message.id)
    return False


COMMANDS: dict[str, Callable[[EditedScenario, Any], None]] = {
    "hello": _hello,
    "edit": _edit,
    "preview": _preview,
    "text": _text,
    "undo": _undo_or_redo,
    "redo": _undo_or_redo,
    "save": _save,
    "reload": _reload,
    "open": _open,
    "template": _template,
    "import": _import,
    "background": _background,
    "trace": _trace,
    "door": _door,
    "run": _run,
    "cancel": _cancel,
}
