"""The worker of the editor: checks and runs in other processes."""

from collections.abc import Callable, Mapping, Sequence
import contextlib
import os
from pathlib import Path
import queue
import threading
from typing import Any

from hunav_drake.editor.worker.handle import Message, ProcessHandle
from hunav_drake.editor.worker.requests import Run, RunRequest
from hunav_drake.editor.worker.results import ResultFolder

# The time limit to stop a run, in seconds; then its process is killed.
STOP_TIME = 1.2

_LOADING = "Loading the simulation takes some seconds."

Callback = Callable[[Message], None]


class Worker:
    """Checks scenarios and runs trials in other processes.

    It has one process of low priority that loads Drake, and more while several
    runs are done in parallel. A process that dies is replaced. Listeners get
    all answers, as messages of plain data:

    - worker {status: "starting" | "ready" | "dead", message}
    - catalog {schema, behaviors, planners, models, robots, metrics, ready}
    - checked {ticket, faults: [{path, message, uses}], models: {file: [...]}}
    - runs {revision, runs: [{run, seed, planner}]}
    - frame {run, time, robots, people, activities, progress}
    - result {run, seed, planner, end_reason, message, end_time, metrics, ...},
      again when the files of the run are written
    - summary {rows: [{planner, metric, n, mean, low, high}]}
    """

    def __init__(
        self,
        *,
        imports: Sequence[str] = (),
        out: str | Path | None = None,
        dispatch: Callable[..., object] | None = None,
    ) -> None:
        """Constructs a Worker without a process.

        Args:
            imports: Modules of users that its processes import.
            out: The folder of the files of runs; by default a temporary folder
                that is removed at the end.
            dispatch: Called from a thread of the worker with a function and
                its arguments, to call it in the thread of the listeners; by
                default it is called in the worker's thread.
        """
        self.results = ResultFolder(out)
        self._imports = list(imports)
        self._dispatch = dispatch or (lambda function, *args: function(*args))
        # One thread sends the messages in order, without the lock.
        self._mail: queue.SimpleQueue[tuple[Callback, Message] | None]
        self._mail = queue.SimpleQueue()
        threading.Thread(target=self._deliver, daemon=True).start()
        self._lock = threading.RLock()
        self._callbacks: list[Callback] = []
        self._first: ProcessHandle | None = None
        # The first process, once it answers questions, before it can run.
        self._answers: ProcessHandle | None = None
        self._ready: set[ProcessHandle] = set()
        self._others: list[ProcessHandle] = []
        self._busy: dict[ProcessHandle, Run] = {}
        self._stopping: set[ProcessHandle] = set()
        self._waiting: list[Run] = []
        self._batch: list[Run] = []
        self._checks = 0
        self._check: Message | None = None
        self._runs = 0
        self._known: dict[str, Message] = {}
        self._closed = False

    def listen(self, callback: Callback) -> Callable[[], None]:
        """Calls a function with each message, first with status and catalog.

        Returns:
            A function that ends this.
        """
        with self._lock:
            self._callbacks.append(callback)
            for message in self._known.values():
                self._mail.put((callback, message))

        def end() -> None:
            with contextlib.suppress(ValueError):
                self._callbacks.remove(callback)

        return end

    def start(self) -> None:
        """Starts the first process, unless it runs."""
        with self._lock:
            if self._first is None and not self._closed:
                self._tell_status("starting", _LOADING)
                self._first = ProcessHandle(self._imports, self._take)

    def check(
        self, text: str, folder: str | Path | None, name: str | None = None
    ) -> int:
        """Requests the faults of a scenario, instead of an earlier request.

        Args:
            text: The scenario's YAML.
            folder: The folder of its relative paths.
            name: The name of the scenario, if the text has several.

        Returns:
            The ticket number of the answer.
        """
        with self._lock:
            self._checks += 1
            self._check = {
                "do": "check",
                "ticket": self._checks,
                "text": text,
                "folder": None if folder is None else str(folder),
                "name": name,
            }
            if self._answers is not None and self._answers is self._first:
                self._answers.send(self._check)
            return self._checks

    def run(self, request: RunRequest, number: Any = None) -> None:
        """Starts the runs of a request, after cancelling the previous ones.

        Args:
            request: The request.
            number: The number of the message that sent it.
        """
        with self._lock:
            self.cancel()
            self._batch = request.runs(self._runs + 1)
            self._runs += len(self._batch)
            self._waiting = list(self._batch)
            self.results.add(self._batch)
            self._tell_runs(self._batch, number)
            self.start()
            most = min(request.workers, os.cpu_count() or 1, len(self._batch))
            while len(self._others) < most - 1:
                other = ProcessHandle(self._imports, self._take)
                self._others.append(other)
            self._begin_runs()

    def repeat(self) -> None:
        """Sends the status and the last results again, for a new view."""
        with self._lock:
            if "worker" in self._known:
                self._tell(self._known["worker"])
            if self._batch:
                self._tell_runs(self._batch)
                for run in self._batch:
                    if run.result is not None:
                        self._tell(run.result)
                self._ask_summary()

    def cancel(self) -> None:
        """Stops all runs within seconds; finished ones stay."""
        with self._lock:
            for run in self._waiting:
                self._finish(run, {"end_reason": "cancelled"})
            self._waiting.clear()
            for handle in list(self._busy):
                if handle not in self._stopping:
                    self._stopping.add(handle)
                    handle.send({"do": "stop"})
                    timer = threading.Timer(
                        STOP_TIME, self._end_if_deaf, (handle,)
                    )
                    timer.daemon = True
                    timer.start()

    def close(self) -> None:
        """Ends all processes; files in a temporary folder are removed."""
        with self._lock:
            self._closed = True
            handles = [*self._others, *filter(None, [self._first])]
            self._callbacks.clear()
            self._first, self._others = None, []
            self._waiting.clear()
            self._busy.clear()
        self._mail.put(None)
        for handle in handles:
            handle.close()
        self.results.close()

    def file(self, token: str, run: str | int, name: str) -> Path | None:
        """Returns a file of a run that has ended: see `ResultFolder.file`."""
        return self.results.file(token, run, name)

    def _tell(self, message: Message) -> None:
        for callback in list(self._callbacks):
            self._mail.put((callback, message))

    def _tell_runs(self, runs: Sequence[Run], number: Any = None) -> None:
        rows = [
            {"run": it.number, "seed": it.seed, "planner": it.planner}
            for it in runs
        ]
        revision = runs[0].request.revision
        message: Message = {"kind": "runs", "revision": revision, "runs": rows}
        if number is not None:
            message["id"] = number
        self._tell(message)

    def _deliver(self) -> None:
        while (letter := self._mail.get()) is not None:
            callback, message = letter
            # The loop of the editor may be gone by now.
            with contextlib.suppress(RuntimeError):
                self._dispatch(callback, message)

    def _tell_status(self, status: str, text: str) -> None:
        message = {"kind": "worker", "status": status, "message": text}
        self._known["worker"] = message
        self._tell(message)

    def _take(self, handle: ProcessHandle, message: Message | None) -> None:
        """Handles a message of a process, in the thread that reads its pipe."""
        last_lines = handle.last_lines() if message is None else ""
        with self._lock:
            if self._closed:
                return
            if message is None:
                self._replace(handle, last_lines)
                return
            match message["kind"]:
                case "worker":
                    self._take_status(handle, message)
                case "catalog":
                    if handle is self._first:
                        self._known["catalog"] = message
                        self._tell(message)
                        self._answers = handle
                        if self._check is not None:
                            handle.send(self._check)
                case "checked":
                    if message["ticket"] == self._checks:
                        self._check = None
                    self._tell(message)
                case "frame":
                    if handle not in self._stopping:
                        self._tell(message)
                case "result":
                    self._finish(self._busy[handle], message)
                    self._ask_summary()
                case "idle":
                    self._take_idle(handle, message)
                case "summary":
                    self._tell(message)

    def _take_status(self, handle: ProcessHandle, message: Message) -> None:
        if message["status"] == "ready":
            self._ready.add(handle)
        if handle is self._first:
            self._tell_status(message["status"], message["message"])
        self._begin_runs()

    def _take_idle(self, handle: ProcessHandle, message: Message) -> None:
        """Handles that a process has finished a run and its files."""
        self._stopping.discard(handle)
        run = self._busy.pop(handle, None)
        if run is not None:
            if run.result is None:
                self._finish(run, {"end_reason": "cancelled"})
            if message["folder"] is not None:
                run.folder = Path(message["folder"])
                run.result = {**(run.result or {}), **self.results.urls(run)}
                self._tell(run.result)
        self._begin_runs()
        if not self._waiting and not self._busy:
            for other in self._others:
                self._ready.discard(other)
                threading.Thread(target=other.close, daemon=True).start()
            self._others.clear()

    def _replace(self, handle: ProcessHandle, last_lines: str) -> None:
        """Replaces a process that has ended."""
        was_ready = handle in self._ready
        was_stopped = handle in self._stopping
        self._ready.discard(handle)
        self._stopping.discard(handle)
        run = self._busy.pop(handle, None)
        if run is not None and run.result is None:
            reason = {"end_reason": "cancelled"}
            if not was_stopped:
                reason = {
                    "end_reason": "failed",
                    "error": f"the process of the run died: {last_lines}",
                }
            self._finish(run, reason)
        if handle is not self._first:
            self._others = [it for it in self._others if it is not handle]
            self._begin_runs()
            return
        self._first = None
        if was_ready:
            if not was_stopped:
                self._tell_status("dead", f"It died: {last_lines}")
            self.start()
        else:
            # It would die again for the same reason.
            self._tell_status("dead", f"It could not start: {last_lines}")
            for waiting in self._waiting:
                self._finish(
                    waiting,
                    {"end_reason": "failed", "error": last_lines or "no start"},
                )
            self._waiting.clear()

    def _end_if_deaf(self, handle: ProcessHandle) -> None:
        with self._lock:
            if handle in self._stopping:
                handle.kill()

    def _begin_runs(self) -> None:
        """Gives waiting runs to free processes."""
        for handle in [self._first, *self._others]:
            if not self._waiting:
                return
            if (
                handle is not None
                and handle in self._ready
                and handle not in self._busy
            ):
                run = self._waiting.pop(0)
                self._busy[handle] = run
                handle.send(
                    {
                        "do": "run",
                        "run": run.number,
                        "seed": run.seed,
                        "planner": run.planner,
                        "text": run.request.text,
                        "folder": run.request.folder,
                        "filename": run.request.filename,
                        "name": run.request.name,
                        "speed": run.request.speed,
                        "out": str(self.results.path),
                    }
                )

    def _finish(self, run: Run, result: Mapping[str, Any]) -> None:
        command = run.command(
            self.results.given,
            own_planner=result.get("own_planner", False),
            imports=self._imports,
        )
        run.result = {
            "kind": "result",
            "run": run.number,
            "seed": run.seed,
            "planner": run.planner,
            "end_reason": None,
            "message": "",
            "end_time": None,
            "metrics": {},
            "texts": {},
            "paths": None,
            "events": [],
            "ends": [],
            "report_url": None,
            "replay_url": None,
            "csv_url": None,
            "command": command,
            "error": None,
            **result,
        }
        self._tell(run.result)

    def _ask_summary(self) -> None:
        """Requests statistics of the finished runs from the first process."""
        rows = [
            {key: it.result.get(key) for key in ("planner", "drawn", "metrics")}
            for it in self._batch
            if it.result is not None and it.result["metrics"]
        ]
        if self._first is not None and rows:
            self._first.send({"do": "summary", "runs": rows})
