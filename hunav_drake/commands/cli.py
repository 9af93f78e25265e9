"""The command `hunav`.

Heavy modules are imported where they are used, so that the command starts
fast.
"""

import argparse
from collections.abc import Iterator, Sequence
import io
import os
import re
import sys
import traceback
from typing import Any, NoReturn
import warnings

from hunav_drake.commands.bench import add_bench_command
from hunav_drake.commands.differences import add_differences_command
from hunav_drake.commands.doctor import add_doctor_command
from hunav_drake.commands.edit import add_edit_command
from hunav_drake.commands.errors import (
    BAD_INPUT,
    DONE,
    FAILED,
    INTERRUPTED,
    os_error_text,
    print_import_hint,
)
from hunav_drake.commands.metrics import add_metric_commands
from hunav_drake.commands.options import AFTER_INTERRUPT, EXAMPLES
from hunav_drake.commands.render import add_render_command
from hunav_drake.commands.report import add_report_command
from hunav_drake.commands.run import add_run_command
from hunav_drake.commands.scenarios import (
    add_completion_command,
    add_new_command,
    add_scenario_commands,
)
from hunav_drake.commands.tree import add_tree_commands
from hunav_drake.commands.validate import add_validate_command
from hunav_drake.systems.common.input_error import InputError, cut
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.trial.user_code import (
    fault_of_user_code,
    import_user_code,
    notes_of,
)

_INVALID_CHOICE = re.compile(
    r"argument (.*): invalid choice: '([^']*)' \(choose from (.*)\)"
)
_MISSING = "the following arguments are required: "


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command, and returns its exit code.

    0 when done, 1 when a trial did not end at its goal, 2 for bad input.
    """
    # A name in another script does not end a run whose output is ASCII.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    options = argparse.Namespace()
    imports: Sequence[str] = ()
    try:
        options = _make_parser().parse_args(arguments)
        imports = getattr(options, "imports", ())
        with warnings.catch_warnings():
            # Only the message is used, so its type does not name the rest.
            warnings.showwarning = _show_warning  # type: ignore[assignment]
            import_user_code(imports)
            code: int = options.function(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        words = sys.argv[1:] if arguments is None else arguments
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
        # Whoever read the output, as in `hunav list | head`, has had enough.
        sys.stderr.close()
        return DONE
    except OSError as error:
        # What is still to be written would fail again when Python ends.
        if isinstance(sys.stdout, io.TextIOWrapper):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print(f"hunav: {cut(os_error_text(error))}", file=sys.stderr)
        return BAD_INPUT
    except Exception as error:
        if getattr(options, "debug", False):
            traceback.print_exc()
            return FAILED
        # (By its name: to import it here would load what other commands do
        # without.)
        if type(error).__name__ == "PlannerError":
            print(f"hunav: {cut(str(error))}", file=sys.stderr)
            return FAILED
        # A planner of one's own may be named as module:Class, too.
        own = imports or ":" in (getattr(options, "planner", None) or "")
        fault = fault_of_user_code(error) if own else ""
        if fault:
            print(f"hunav: {fault}", file=sys.stderr)
            return BAD_INPUT
        words = " ".join(f"{type(error).__name__}: {error}".split())
        notes = "".join(f" ({note})" for note in notes_of(error))
        print(
            f"hunav: {cut(words + notes)}\nhunav: this may be a fault of"
            " hunav_drake; --debug shows where it comes from",
            file=sys.stderr,
        )
        return FAILED
    return code


def _show_warning(message: Warning | str, *_: object) -> None:
    print(f"hunav: warning: {message}", file=sys.stderr)


class _Parser(argparse.ArgumentParser):
    """Tells in one line what is wrong with the words of a command."""

    def error(self, message: str) -> NoReturn:
        """Prints what is wrong, and exits."""
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
                near = f"; to {names[0]} it, write {names[0]} before it"
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
    """Prints the version; it is looked up only then."""

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


def _make_parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="hunav",
        description="Simulates people around robots, and measures how socially"
        " the robots navigate.",
    )
    parser.add_argument(
        "--version", action=_Version, help="show the version and exit"
    )
    commands = parser.add_subparsers(
        title="commands", required=True, metavar="COMMAND"
    )
    add_run_command(commands)
    add_scenario_commands(commands)
    add_edit_command(commands)
    add_metric_commands(commands)
    add_report_command(commands)
    add_render_command(commands)
    add_tree_commands(commands)
    add_bench_command(commands)
    add_differences_command(commands)
    add_validate_command(commands)
    add_doctor_command(commands)
    add_new_command(commands)
    add_completion_command(commands, parser)
    for command in _all_commands(parser):
        _add_debug_option(command)
        words = command.prog.removeprefix(parser.prog).strip()
        if words in EXAMPLES:
            command.epilog = f"Example: {EXAMPLES[words]}"
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
        # Without a default, it may stand before and after the command.
        default=argparse.SUPPRESS,
        help="show where in the code an error comes from",
    )


if __name__ == "__main__":
    sys.exit(main())
