"""Imports user code: tree nodes, motion models, planners and metrics."""

from collections.abc import Iterable
import importlib
import importlib.util
from pathlib import Path
import sys
import traceback

from hunav_drake.systems.common.input_error import InputError

_PACKAGE = str(Path(__file__).resolve().parents[1])


def import_user_code(names: Iterable[str]) -> None:
    """Imports modules that register parts of a simulation.

    Names are paths of Python files, or modules, installed or in the current
    folder. Raises an InputError with the line of a failing import.
    """
    for name in names:
        try:
            if name.endswith(".py"):
                _import_file(Path(name))
            else:
                if str(Path.cwd()) not in sys.path:
                    sys.path.insert(0, str(Path.cwd()))
                importlib.import_module(name)
        except OSError as error:
            raise InputError(f"--import {name}: {error.strerror}") from error
        except Exception as error:
            raise InputError(
                f"--import {name}: {_place(error)}{type(error).__name__}:"
                f" {error}"
            ) from error


def fault_of_user_code(error: BaseException | None) -> str:
    """Returns the error in user code and its place, or an empty text.

    The causes of the exception are searched, too.
    """
    notes = ""
    first = error
    while error is not None:
        notes = notes or "".join(f" ({note})" for note in notes_of(error))
        frames = [
            frame
            for frame in traceback.extract_tb(error.__traceback__)
            if not frame.filename.startswith((_PACKAGE, sys.prefix, "<"))
            and sys.base_prefix not in frame.filename
        ]
        if frames:
            place = f"{frames[-1].filename}:{frames[-1].lineno}"
            return f"{place}: {type(error).__name__}: {error}{notes}"
        error = error.__cause__
    # Or raised in this package, about a result of user code.
    return f"{type(first).__name__}: {first}{notes}" if notes else ""


def notes_of(error: BaseException) -> list[str]:
    """Returns the notes of an exception."""
    return list(getattr(error, "__notes__", ()))


def _import_file(path: Path) -> None:
    path.open().close()
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ImportError("is not a Python file")
    module = importlib.util.module_from_spec(spec)
    # As an import does, for code that looks up the module of a class.
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)


def _place(error: Exception) -> str:
    """Returns the line of user code that raised an error."""
    if isinstance(error, SyntaxError):
        return ""
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename != __file__ and "importlib" not in frame.filename
    ]
    return f"{frames[0].filename}:{frames[0].lineno}: " if frames else ""
