"""The child's end of the pipe: what it says, and what it is asked."""

from collections import deque
import json
from multiprocessing.connection import Connection
import os

from hunav_drake.editor.worker.handle import Message


class Stopped(Exception):
    """The parent does not want the run any more."""


class Channel:
    """The child's end of the pipe."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._waiting: deque[Message] = deque()

    def send(self, message: Message) -> None:
        """Sends a message to the parent."""
        self._connection.send_bytes(json.dumps(message).encode())

    def next(self) -> Message:
        """Returns the next message, as soon as there is one."""
        if not self._waiting:
            self._waiting.append(self._read())
        message = self._waiting.popleft()
        # Of questions about a text, the last one counts.
        self._read_all()
        while message["do"] == "check" and any(
            it["do"] == "check" for it in self._waiting
        ):
            message = self._waiting.popleft()
        return message

    def look(self) -> None:
        """Answers questions during a run; other messages wait.

        Raises:
            Stopped: If the parent wants no more of it.
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
            # The parent is gone: nobody is left to work for.
            os._exit(0)
        return message


# What is answered at once, of each kind the last one.
_ANSWERS = ("check", "summary")


def answer(channel: Channel, message: Message) -> None:
    """Answers a question."""
    # The process loads these last, when it ends with its parent already.
    if message["do"] == "check":
        from hunav_drake.editor.worker.names import (
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
            }
        )
    else:
        from hunav_drake.editor.worker.statistics import summary_rows

        rows = summary_rows(message["runs"])
        channel.send({"kind": "summary", "rows": rows})
