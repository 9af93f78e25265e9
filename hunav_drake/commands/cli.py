"""The command `hunav`.

To start fast, it loads only the module of the command that is called, and
heavy modules where they are used.
"""

import argparse
import atexit
from collections.abc import Iterator, Sequence
import gc
import importlib
import io
import os
import re
import sys
import traceback
from typing import Any, NoReturn
import warnings

from hunav_drake.commands.errors import (
    BAD_INPUT,
    DONE,
    FAILED,
    INTERRUPTED,
    os_error_text,
    print_import_hint,
)
from hunav_drake.commands.options import AFTER_INTERRUPT, EXAMPLES
from hunav_drake.systems.common.input_error import InputError, cut
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.trial.user_code import (
    fault_of_user_code,
    import_user_code,
    notes_of,
)

# The commands: the module of each, and its line of help.
_COMMANDS = {
    "run": ("run", "run a trial and print its metrics"),
    "list": ("scenarios", "list the shipped scenarios"),
    "check": ("scenarios", "check scenario files"),
    "schema": ("scenarios", "show the JSON schema of scenarios, for editors"),
    "import": ("scenarios", "convert an agents.yaml of HuNavSim to a scenario"),
    "tracks": ("tracks", "show and convert recorded people"),
    "fit": ("fit", "fit the weights of forces to recorded people"),
    "edit": ("edit", "edit a scenario in the browser"),
    "evaluate": ("metrics", "compute the metrics of a recording"),
    "situations": (
        "situations",
        "tell what a robot met in a recording, and when",
    ),
    "branch": ("branch", "run a trial on in several ways from one instant"),
    "who": ("branch", "tell who delayed whom in a trial"),
    "metrics": ("metrics", "list and explain the metrics"),
    "report": ("report", "make a report on all runs of a folder"),
    "render": ("render", "make a film or a picture of a recorded run"),
    "export": ("ros2", "write a run to a bag of ROS 2"),
    "bridge": ("ros2", "let Nav2 or another program drive the robot"),
    "tree": ("tree", "show, check and convert behavior trees"),
    "bench": ("bench", "compare planners over scenarios and seeds"),
    "falsify": ("failures", "search for scenes in which a planner fails"),
    "risk": ("failures", "estimate how likely a planner fails"),
    "differences": (
        "differences",
        "list the differences from HuNavSim, with reasons",
    ),
    "validate": ("validate", "test how realistically motion models walk"),
    "doctor": ("doctor", "check this installation, and run a short test"),
    "new": ("scenarios", "write a small scenario to start from"),
    "generate": ("generate", "write scenarios that are drawn from a seed"),
    "completion": (
        "scenarios",
        "print a script for the completion of commands in a shell",
    ),
}

_INVALID_CHOICE = re.compile(
    r"argument (.*): invalid choice: '([^']*)' \(choose from (.*)\)"
)
_MISSING = "the following arguments are required: "


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command, and returns its exit code.

    0: done; 1: a trial did not end at its goal; 2: bad input.
    """
    # A closed output (`>&-`) is None in Python.
    sys.stdout, sys.stderr = (
        stream or os.fdopen(os.open(os.devnull, os.O_WRONLY), "w")
        for stream in (sys.stdout, sys.stderr)
    )
    # Names in other scripts do not fail where the output is ASCII.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    options = argparse.Namespace()
    words = sys.argv[1:] if arguments is None else arguments
    if arguments is None:
        # What is loaded stays: to look through it again and again for garbage,
        # and a last time at the end, takes a quarter of the time of a command.
        gc.set_threshold(400_000)
        atexit.register(gc.freeze)
    imports: Sequence[str] = ()
    try:
        options = _make_parser(words).parse_args(words)
        # Whether this process is for the command only.
        options.alone = arguments is None
        imports = getattr(options, "imports", ())
        with warnings.catch_warnings():
            # Its type is that of a function with more arguments.
            warnings.showwarning = _show_warning  # type: ignore[assignment]
            _check_here()
            import_user_code(imports)
            code: int = options.function(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        command = next((word for word in words if word in EXAMPLES), "")
        hint = AFTER_INTERRUPT.get(command, "")
        print(
            f"hunav: interrupted{f': {hint}' if hint else ''}", file=sys.stderr
        )
        return INTERRUPTED
    except InputError as error:
        if getattr(options, "debug", False):
            traceback.print_exc()
        print(f"hunav: {error}", file=sys.stderr)
        print_import_hint(error, options)
        return BAD_INPUT
    except BrokenPipeError:
        # The reader of the output, as in `hunav list | head`, has ended.
        sys.stderr.close()
        return DONE
    except OSError as error:
        # Output that is still buffered would fail again when Python ends.
        if isinstance(sys.stdout, io.TextIOWrapper):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print(f"hunav: {cut(os_error_text(error))}", file=sys.stderr)
        return BAD_INPUT
    except Exception as error:
        if getattr(options, "debug", False):
            traceback.print_exc()
            return FAILED
        # By its name: an import would load modules that others do not need.
        if type(error).__name__ == "PlannerError":
            print(f"hunav: {cut(str(error))}", file=sys.stderr)
            return FAILED
        # A user's planner may also be given as module:Class.
        own = imports or ":" in (getattr(options, "planner", None) or "")
        fault = fault_of_user_code(error) if own else ""
        if fault:
            print(f"hunav: {fault}", file=sys.stderr)
            return BAD_INPUT
        told = " ".join(f"{type(error).__name__}: {error}".split())
        notes = "".join(f" ({note})" for note in notes_of(error))
        print(
            f"hunav: {cut(told + notes)}\nhunav: this may be a bug in"
            " hunav_drake; --debug shows where it happens",
            file=sys.stderr,
        )
        return FAILED
    return code


def _check_here() -> None:
    """Refuses a current folder that does not exist: no path starts there."""
    try:
        os.getcwd()
    except FileNotFoundError as error:
        raise InputError(
            "the current folder was deleted; go to one that exists, as by cd ~"
        ) from error


def _show_warning(message: Warning | str, *_: object) -> None:
    print(f"hunav: warning: {message}", file=sys.stderr)


class _Parser(argparse.ArgumentParser):
    """Parser that prints errors in one line."""

    def error(self, message: str) -> NoReturn:
        """Prints the error, and exits."""
        commands = [
            name
            for action in self._actions
            if isinstance(action, argparse._SubParsersAction)
            for name in action.choices
        ]
        if match := _INVALID_CHOICE.search(message):
            option, word = match[1], match[2]
            names = re.findall(r"[\w-]+", match[3])
            near = did_you_mean(word, names)
            if len(names) == 1:
                near = f"; write {names[0]} before it to {names[0]} it"
            message = (
                f"there is no command {word!r}{near}; valid: {', '.join(names)}"
                if names == commands
                else f"{option}: must be one of {', '.join(names)}, got"
                f" {word!r}{did_you_mean(word, names)}"
            )
        elif commands and message.startswith(_MISSING):
            message = f"name a command: {', '.join(commands)}"
        message = cut(message.removeprefix("argument "))
        self.exit(
            BAD_INPUT, f"{self.prog}: {message}; see `{self.prog} --help`\n"
        )


class _Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __init__(self, option_strings: Any, dest: str, **settings: Any) -> None:
        """Constructs an option without a value."""
        super().__init__(option_strings, dest, nargs=0, **settings)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Prints the version of the package, of Python and of Drake."""
        from importlib.metadata import version
        import platform

        print(
            f"hunav_drake {version('hunav_drake')} (Python"
            f" {platform.python_version()}, Drake {version('drake')})"
        )
        parser.exit()


def _make_parser(words: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """Returns the parser.

    Args:
        words: The command line: only the commands in it get their options,
            because loading the modules of all commands takes long. By default
            all commands do.
    """
    parser = _Parser(
        prog="hunav",
        description="Simulates people around robots, and evaluates how socially"
        " robots navigate.",
    )
    parser.add_argument(
        "--version", action=_Version, help="show the version and exit"
    )
    commands = parser.add_subparsers(
        title="commands", required=True, metavar="COMMAND"
    )
    for name, (module, text) in _COMMANDS.items():
        command = commands.add_parser(name, help=text)
        if words is None or name in words:
            add = getattr(
                importlib.import_module(f"hunav_drake.commands.{module}"),
                f"add_{name}_options",
            )
            add(command)
    # For `hunav completion`.
    parser.set_defaults(make_parser=_make_parser)
    for it in _all_commands(parser):
        _add_debug_option(it)
        called = it.prog.removeprefix(parser.prog).strip()
        if called in EXAMPLES:
            it.epilog = f"Example: {EXAMPLES[called]}"
    return parser


def _all_commands(
    parser: argparse.ArgumentParser,
) -> Iterator[argparse.ArgumentParser]:
    """Yields a parser and those of all its commands."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _all_commands(command)


def _add_debug_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--debug",
        action="store_true",
        # Without a default, it may come before or after the command.
        default=argparse.SUPPRESS,
        help="show the traceback of an error",
    )


if __name__ == "__main__":
    sys.exit(main())
