"""An editing session of one scenario: messages in and out."""

from typing import Any

from hunav_drake.editor.background import BackgroundError
from hunav_drake.editor.commands import COMMANDS
from hunav_drake.editor.document.plain_data import OperationError
from hunav_drake.editor.edited_scenario import EditedScenario
from hunav_drake.editor.files import FileRefusedError
from hunav_drake.editor.messages import MessageError, id_of, read_message
from hunav_drake.scenario.error import ScenarioError
from hunav_drake.systems.common.choice_loading import registered_only


class EditSession(EditedScenario):
    """Edits a scenario by messages to `receive`."""

    def receive(self, message: Any) -> None:
        """Handles a message.

        If it fails, the answer is an ``error``, and nothing has changed.
        """
        with self._lock, registered_only():
            number = id_of(message)
            try:
                known = read_message(message)
                COMMANDS[known.do](self, known)
            except (
                MessageError,
                OperationError,
                FileRefusedError,
                BackgroundError,
                OSError,
            ) as error:
                self.send("error", number, message=_line(error))
            except ScenarioError as error:
                self.send(
                    "error",
                    number,
                    message=_line(error.faults[0]),
                    faults=[_line(fault) for fault in error.faults],
                )

    def poll(self) -> None:
        """Checks whether another program has changed the file.

        If so, it is read again; if there are unsaved changes, asks first, once.
        """
        with self._lock:
            file = self.state.file
            if not file.is_news():
                return
            if not self.state.is_dirty:
                self.receive({"do": "reload", "confirm": True})
                return
            self.send(
                "ask",
                question=f"{file.path} was changed by another program. Reload"
                " it? Undo restores your changes.",
                again={"do": "reload", "confirm": True},
            )


def _line(error: object) -> str:
    """Returns an error in one line."""
    return " ".join(str(error).split())
