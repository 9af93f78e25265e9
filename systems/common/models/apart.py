"""Tries a function in a process of its own, which a crash may end.

Drake reads models of files, and some of those end the process that reads them.
"""

from collections.abc import Hashable
import importlib
import json
import signal
import subprocess
import sys
from typing import Any

# The time limit for a file, in seconds.
_PATIENCE = 60.0

_CHILD = (
    "import json, sys; request = json.load(sys.stdin);"
    " sys.path[:] = request['path'];"
    f" from {__name__} import answer; answer(request)"
)

# The calls that succeeded in this process, and whether this is the other one.
_passed: set[Hashable] = set()
_is_other = False


class ModelFault(ValueError):
    """A fault of a model of a file.

    Attributes:
        place: The setting that it is about, of the configuration of the file.
    """

    def __init__(self, place: tuple[str, ...], message: str) -> None:
        super().__init__(message)
        self.place = place


def try_apart(key: Hashable, function: str, *arguments: Any) -> None:
    """Calls a function in another process, to see whether it succeeds.

    It is given as "module:name"; its arguments are values that JSON can hold.
    The outcome follows from the key: calls that succeeded are not repeated.

    Raises:
        ModelFault: If the function raises one, or anything else, or ends its
            process, or takes longer than a minute.
    """
    if _is_other or (function, key) in _passed:
        return
    request = {"path": sys.path, "function": function, "arguments": arguments}
    try:
        done = subprocess.run(
            [sys.executable, "-c", _CHILD],
            input=json.dumps(request),
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise ModelFault(
            ("file",),
            f"cannot be read within {_PATIENCE:g} s; take models that include"
            " each other apart, or take simpler meshes",
        ) from None
    if done.returncode < 0:
        raise ModelFault(
            ("file",),
            f"crashes Drake ({signal.Signals(-done.returncode).name}), as files"
            " that include themselves do, and planes among collision shapes"
            " beside a dozen others; take these out, or find the part that does"
            " it by leaving parts out",
        )
    try:
        place, message = json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        line = " ".join(done.stderr.split())[-300:]
        raise ModelFault(
            ("file",), f"ends the process that reads it: {line}"
        ) from None
    if message:
        raise ModelFault(tuple(place), message)
    _passed.add((function, key))


def answer(request: dict[str, Any]) -> None:
    """Calls the function of a request, and prints the outcome as JSON."""
    global _is_other
    _is_other = True
    module, _, name = request["function"].partition(":")
    function = getattr(importlib.import_module(module), name)
    place: tuple[str, ...] = ("file",)
    message = ""
    try:
        function(*request["arguments"])
    except ModelFault as fault:
        place, message = fault.place, str(fault)
    except (Exception, SystemExit) as error:
        message = f"cannot be simulated: {drake_words(error)}"
    print("\n" + json.dumps([place, message]), flush=True)


def drake_words(error: BaseException) -> str:
    """Returns the text of an error of Drake's, in a line of limited length.

    A SystemExit tells which condition does not hold in its code.
    """
    words = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, SystemExit):
        words = words.partition("condition ")[2] or words
    return words if len(words) <= 300 else f"{words[:297]}..."
