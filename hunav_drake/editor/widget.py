"""The editor as a widget of notebooks."""

import asyncio
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
import re
import time
from typing import TYPE_CHECKING, Any

import anywidget
import traitlets

from hunav_drake.editor.session import EditSession
from hunav_drake.editor.worker import Worker
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenarios import shipped_names, shipped_text
from hunav_drake.trial.user_code import import_user_code

if TYPE_CHECKING:
    from hunav_drake.trial.result import TrialResult

_STATIC = resources.files("hunav_drake.editor") / "static"
_IMPORT = re.compile(r'from "\./([\w-]+\.js)"')

# The least time between checks of the file, in seconds.
_LOOK = 2.0


def modules_in_order(first: str = "editor.js") -> list[tuple[str, str]]:
    """Returns names and texts of front-end modules, each after its imports.

    Args:
        first: The file name of the last module.
    """
    found: dict[str, str] = {}

    def add(name: str) -> None:
        if name not in found:
            text = (_STATIC / name).read_text("utf-8")
            for other in _IMPORT.findall(text):
                add(other)
            found[name] = text

    add(first)
    return list(found.items())


class ScenarioEditor(anywidget.AnyWidget):
    """A scenario that is edited in a notebook: see `EditScenario`."""

    _esm = (_STATIC / "widget.js").read_text("utf-8")
    _css = "".join(
        (_STATIC / name).read_text("utf-8")
        for name in ("editor.css", "map.css", "panels.css")
    )
    _modules: Any = traitlets.List().tag(sync=True)
    _height = traitlets.Int(640).tag(sync=True)

    def __init__(
        self,
        scenario: Scenario | str | Path | None = None,
        *,
        imports: Sequence[str] = (),
        height: int = 640,
    ) -> None:
        """Constructs the widget; its arguments are those of `EditScenario`."""
        imports = (imports,) if isinstance(imports, str) else tuple(imports)
        import_user_code(imports)
        text, filename = _source(scenario)
        self._worker = Worker(imports=imports, dispatch=_dispatch())
        self._session = EditSession(
            text,
            scenario=scenario if isinstance(scenario, Scenario) else None,
            filename=filename,
            imports=imports,
            worker=self._worker,
        )
        self._looked = 0.0
        super().__init__(
            _modules=[list(it) for it in modules_in_order()], _height=height
        )
        self._session.subscribe(self.send)
        self.on_msg(self._receive)

    def __repr__(self) -> str:
        path = self._session.state.file.path
        command = f"hunav edit {path or 'FILE'}"
        return f"The scenario editor. If it is not visible here: {command}"

    @property
    def scenario(self) -> Scenario:
        """The current scenario.

        Raises:
            ScenarioError: If it has faults.
        """
        return self._session.scenario

    @property
    def text(self) -> str:
        """The scenario as YAML."""
        return self._session.text

    @property
    def faults(self) -> list[dict[str, Any]]:
        """Its faults: mappings with path, message, remedy, ..."""
        return self._session.faults

    @property
    def results(self) -> "list[TrialResult]":
        """The results of all runs in the editor that have ended."""
        from hunav_drake.runs.result_files import LoadResults

        folders = [it.name for it in self._worker.results.folders()]
        if not folders:
            return []
        found = {it.tag: it for it in LoadResults(self._worker.results.path)}
        return [found[name] for name in folders if name in found]

    def save(self, filename: str | Path | None = None) -> None:
        """Writes the scenario.

        Args:
            filename: The file; by default the one that was opened or saved.

        Raises:
            ValueError: If there is no file, or it cannot be written.
        """
        self._session.save(filename)

    def on_change(
        self, function: Callable[["ScenarioEditor"], object]
    ) -> Callable[[], None]:
        """Calls a function with the widget after each change.

        Returns:
            A function that ends this.
        """
        known = self._session.state.revision

        def listen(message: dict[str, Any]) -> None:
            nonlocal known
            # The text is the last message of a change.
            if message["kind"] == "text" and message["revision"] != known:
                known = message["revision"]
                function(self)

        return self._session.subscribe(listen)

    def close(self) -> None:
        """Closes the widget, and ends its process."""
        if "_session" in self.__dict__:
            self._session.close()
        super().close()

    def _receive(self, _: Any, message: Any, buffers: Any) -> None:
        """Handles a message of the front end."""
        if isinstance(message, dict) and message.get("do") == "result_file":
            self._send_file(message)
            return
        if isinstance(message, dict) and message.get("do") == "hello":
            # Only now, because a widget may never be shown.
            self._worker.start()
        now = time.monotonic()
        if now - self._looked > _LOOK:
            self._looked = now
            self._session.poll()
        self._session.receive(message)

    def _send_file(self, message: dict[str, Any]) -> None:
        """Sends a file of a run, which has no address in a notebook."""
        run, name = str(message.get("run")), str(message.get("name"))
        path = self._worker.file(self._worker.results.token, run, name)
        if path is None:
            self.send({"kind": "error", "message": "The file does not exist."})
            return
        # Its link to another page would not work.
        content = path.read_bytes().replace(b'href="replay.html"', b"")
        answer = {"kind": "result_file", "run": run, "name": name}
        self.send(answer, buffers=[content])


def _source(
    scenario: Scenario | str | Path | None,
) -> tuple[str | None, Path | None]:
    """Returns the text and the file of a scenario argument."""
    if scenario is None or isinstance(scenario, Scenario):
        return None, None
    if isinstance(scenario, str) and ("\n" in scenario or ": " in scenario):
        return scenario, None
    path = Path(scenario)
    if not path.exists() and str(scenario) in shipped_names():
        return shipped_text(str(scenario)), None
    if not path.exists() and path.suffix not in (".yaml", ".yml"):
        raise ValueError(
            f"there is no file or shipped scenario {str(scenario)!r:.80}; the"
            " name of a new file ends in .yaml"
        )
    return None, path


def _dispatch() -> Callable[..., object] | None:
    """Returns a function that calls others in the thread of the cells."""
    try:
        return asyncio.get_running_loop().call_soon_threadsafe
    except RuntimeError:
        return None
