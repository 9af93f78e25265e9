"""The parent's handle of a process of the editor's worker."""

from collections.abc import Callable, Sequence
import contextlib
import json
from multiprocessing.connection import Connection, Pipe
import subprocess
import sys
import tempfile
import threading
from typing import Any

Message = dict[str, Any]

# The code of a new interpreter: it has the module path of its parent, but does
# not run the parent's script again.
_BEGIN = (
    "import json, sys;"
    " sys.path[:] = json.loads(sys.argv[1]);"
    " from hunav_drake.editor.worker.child import main;"
    " main(int(sys.argv[2]), json.loads(sys.argv[3]))"
)

# How much of the output of a dead process is shown.
_LAST_LINES = 5
_LAST_BYTES = 4000

# The time limit for a process to end, in seconds.
_PATIENCE = 0.5


class ProcessHandle:
    """A process that sends and receives messages, as JSON on a pipe.

    The parent keeps only its own end open, so the pipe ends with the process.
    """

    def __init__(
        self,
        imports: Sequence[str],
        receive: Callable[["ProcessHandle", Message | None], None],
    ) -> None:
        """Starts a process.

        Args:
            imports: Modules of users that it imports: see `import_user_code`.
            receive: Called from a thread with each message, and with None once
                the process has ended.
        """
        self._connection, theirs = Pipe()
        # The thread `_read` closes it.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        self._receive = receive
        self._is_closed = False
        with theirs:
            self._process = subprocess.Popen(
                [
                    *(sys.executable, "-c", _BEGIN),
                    json.dumps([path or "." for path in sys.path]),
                    str(theirs.fileno()),
                    json.dumps(list(imports)),
                ],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=self._errors,
                stderr=self._errors,
                # Ctrl-C in the terminal is for the parent, which ends it.
                start_new_session=True,
            )
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def send(self, message: Message) -> None:
        """Sends a message; it is lost if the process has ended."""
        with contextlib.suppress(OSError):
            self._connection.send_bytes(json.dumps(message).encode())

    def kill(self) -> None:
        """Kills the process; `receive` is called with None."""
        self._process.kill()

    def close(self) -> None:
        """Ends the process; `receive` is not called any more."""
        self._is_closed = True
        # The process also ends with its pipe.
        with contextlib.suppress(OSError):
            self.send({"do": "end"})
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._thread.join(_PATIENCE)

    def last_lines(self) -> str:
        """Returns the last output of the process."""
        try:
            self._errors.seek(0, 2)
            self._errors.seek(max(self._errors.tell() - _LAST_BYTES, 0))
            text = self._errors.read().decode(errors="replace")
        except (OSError, ValueError):
            return ""
        lines = text.strip().splitlines()[-_LAST_LINES:]
        return "\n".join(lines) or f"exit code {self._process.poll()}"

    def _read(self) -> None:
        connection: Connection = self._connection
        while True:
            try:
                message = json.loads(connection.recv_bytes())
            except (EOFError, OSError):
                break
            if not self._is_closed:
                self._receive(self, message)
        # A process without a pipe has ended, or is useless.
        self._process.kill()
        self._process.wait()
        if not self._is_closed:
            self._receive(self, None)
        connection.close()
        self._errors.close()
