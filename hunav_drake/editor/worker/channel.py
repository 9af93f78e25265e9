"""The child's end of the pipe."""

from collections import deque
import json
from multiprocessing.connection import Connection
import os

from hunav_drake.editor.worker.handle import Message

# A check waits for a pause in the changes, in seconds.
_PAUSE = 0.2


class Stopped(Exception):
    """The parent has cancelled the run."""


class Channel:
    """Sends and receives messages in the child process."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._waiting: deque[Message] = deque()

    def send(self, message: Message) -> None:
        """Sends a message to the parent."""
        self._connection.send_bytes(json.dumps(message).encode())

    def next(self) -> Message:
        """Waits for the next message, and returns it."""
        if not self._waiting:
            self._waiting.append(self._read())
        message = self._waiting.popleft()
        # Only the last check is needed.
        if message["do"] == "check":
            while not self._waiting and self._connection.poll(_PAUSE):
                self._waiting.append(self._read())
                if self._waiting[0]["do"] == "check":
                    message = self._waiting.popleft()
        self._read_all()
        while message["do"] == "check" and any(
            it["do"] == "check" for it in self._waiting
        ):
            message = self._waiting.popleft()
        return message

    def look(self) -> None:
        """Answers questions during a run; other messages wait.

        Raises:
            Stopped: If the parent cancels the run.
        """
        self._read_all()
        for message in [*self._waiting]:
            if message["do"] in ("stop", "end"):
                if message["do"] == "stop":
                    self._waiting.remove(message)
                raise Stopped
        if any(it["do"] in _ANSWERS for it in self._waiting):
            others = [it for it in self._waiting if it["do"] not in _ANSWERS]
            asked = {it["do"]: it for it in self._waiting if it not in others}
            self._waiting = deque(others)
            for message in asked.values():
                answer(self, message)

    def _read_all(self) -> None:
        while self._connection.poll():
            self._waiting.append(self._read())

    def _read(self) -> Message:
        try:
            message: Message = json.loads(self._connection.recv_bytes())
        except (EOFError, OSError):
            # The parent has ended.
            os._exit(0)
        return message


# Questions that are answered at once; of each kind only the last one.
_ANSWERS = ("check", "summary")


def answer(channel: Channel, message: Message) -> None:
    """Answers a question."""
    # Loaded late, so that the process can end with its parent meanwhile.
    if message["do"] == "check":
        from hunav_drake.editor.worker.names import (
            find_drawn_people,
            find_model_outlines,
            find_names_faults,
        )

        question = message["text"], message["folder"], message["name"]
        channel.send(
            {
                "kind": "checked",
                "ticket": message["ticket"],
                "faults": find_names_faults(*question),
                "models": find_model_outlines(*question),
                "drawn": find_drawn_people(*question),
            }
        )
    else:
        from hunav_drake.editor.worker.statistics import summary_rows

        rows = summary_rows(message["runs"])
        channel.send({"kind": "summary", "rows": rows})
