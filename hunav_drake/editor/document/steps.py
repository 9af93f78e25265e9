"""The history of an editing session, for undo and redo."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
import time
from typing import Any

from hunav_drake.editor.document.text_patch import (
    Patches,
    difference,
    inverse,
    patched,
)

# The maximum number of steps, and the time within which similar steps are
# merged, in seconds.
MAX_STEPS = 1000
_MERGE_TIME = 1.0


@dataclass(frozen=True)
class Step:
    """The changes of one step.

    Attributes:
        label: Its label on buttons: "Move bruno".
        patches: The patches of the text.
        before: The data before.
        after: The data after.
        key: Steps with the same key shortly after each other are merged; None
            for a step that is never merged.
    """

    label: str
    patches: Patches
    before: Any
    after: Any
    key: Hashable = None


class Steps:
    """The done and the undone steps."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Starts without steps; the clock returns seconds."""
        self._clock = clock
        self._done: list[Step] = []
        self._undone: list[Step] = []
        # The time of the last step, unless it was undone.
        self._last = -1e9

    @property
    def undo_label(self) -> str | None:
        """The label of the step to undo, if there is one."""
        return self._done[-1].label if self._done else None

    @property
    def redo_label(self) -> str | None:
        """The label of the step to redo, if there is one."""
        return self._undone[-1].label if self._undone else None

    def add(self, step: Step, text: str) -> None:
        """Adds a step that resulted in a text."""
        now = self._clock()
        last = self._done[-1] if self._done else None
        if (
            last is not None
            and step.key is not None
            and step.key == last.key
            and now - self._last <= _MERGE_TIME
        ):
            middle = patched(text, inverse(step.patches))
            first = patched(middle, inverse(last.patches))
            self._done[-1] = replace(
                step, patches=difference(first, text), before=last.before
            )
        else:
            self._done.append(step)
            del self._done[:-MAX_STEPS]
        self._undone.clear()
        self._last = now

    def undo(self, text: str) -> tuple[str, Any] | None:
        """Returns text and data before the last step; None without one."""
        if not self._done:
            return None
        step = self._done.pop()
        self._undone.append(step)
        self._last = -1e9
        return patched(text, inverse(step.patches)), step.before

    def redo(self, text: str) -> tuple[str, Any] | None:
        """Returns text and data after the next undone step, if any."""
        if not self._undone:
            return None
        step = self._undone.pop()
        self._done.append(step)
        self._last = -1e9
        return patched(text, step.patches), step.after
