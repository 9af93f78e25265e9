"""Tries a function in a process of its own, which a crash may end.

Drake reads models of files, and some of those end the process that reads them.
"""

from collections.abc import Callable, Hashable
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

# What calls returned in this process, and whether this is the other one.
_passed: dict[Hashable, Any] = {}
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

    It does nothing in such a process. See `call_apart`.
    """
    if not _is_other:
        call_apart(key, function, *arguments)


def call_apart(key: Hashable, function: str, *arguments: Any) -> Any:
    """Returns what a function returns in another process.

    It is given as "module:name"; its arguments, and what it returns, are values
    that JSON can hold. The outcome follows from the key: calls that succeeded
    are not repeated. In such a process it is simply called.

    Raises:
        ModelFault: If the function raises one, or anything else, or ends its
            process, or takes longer than a minute.
    """
    if _is_other:
        return _find(function)(*arguments)
    if (function, key) in _passed:
        return _passed[function, key]
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
        place, message, result = json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        line = " ".join(done.stderr.split())[-300:]
        raise ModelFault(
            ("file",), f"ends the process that reads it: {line}"
        ) from None
    if message:
        raise ModelFault(tuple(place), message)
    _passed[function, key] = result
    return result


def _find(function: str) -> Callable[..., Any]:
    module, _, name = function.partition(":")
    found: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return found


def answer(request: dict[str, Any]) -> None:
    """Calls the function of a request, and prints the outcome as JSON."""
    global _is_other
    _is_other = True
    function = _find(request["function"])
    place: tuple[str, ...] = ("file",)
    message = ""
    result = None
    try:
        result = function(*request["arguments"])
    except ModelFault as fault:
        place, message = fault.place, str(fault)
    except (Exception, SystemExit) as error:
        message = f"cannot be simulated: {drake_words(error)}"
    print("\n" + json.dumps([place, message, result]), flush=True)


def drake_words(error: BaseException) -> str:
    """Returns the text of an error of Drake's, in a line of limited length.

    A SystemExit tells which condition does not hold in its code.
    """
    words = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, SystemExit):
        words = words.partition("condition ")[2] or words
    return words if len(words) <= 300 else f"{words[:297]}..."
