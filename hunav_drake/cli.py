"""The command `hunav`.

Heavy modules are imported where they are used, so that the command starts
fast.
"""

import argparse
from collections.abc import Sequence
import io
import os
import sys
import traceback
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
    InputError,
    print_import_hint,
)
from hunav_drake.commands.metrics import add_metric_commands
from hunav_drake.commands.render import add_render_command
from hunav_drake.commands.report import add_report_command
from hunav_drake.commands.run import add_run_command
from hunav_drake.commands.scenarios import add_scenario_commands
from hunav_drake.commands.tree import add_tree_commands
from hunav_drake.commands.user_code import fault_of_user_code, import_user_code
from hunav_drake.commands.validate import add_validate_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command, and returns its exit code.

    0 when done, 1 when a trial did not end at its goal, 2 for bad input.
    """
    # A name in another script does not end a run whose output is ASCII.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    options = _make_parser().parse_args(arguments)
    imports = getattr(options, "imports", ())
    try:
        with warnings.catch_warnings():
            # Only the message is used, so its type does not name the rest.
            warnings.showwarning = _show_warning  # type: ignore[assignment]
            import_user_code(imports)
            code: int = options.function(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        print("hunav: interrupted", file=sys.stderr)
        return INTERRUPTED
    except InputError as error:
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
        print(f"hunav: {error}", file=sys.stderr)
        return BAD_INPUT
    except Exception as error:
        if getattr(options, "debug", False):
            traceback.print_exc()
            return FAILED
        # (By its name: to import it here would load what other commands do
        # without.)
        if type(error).__name__ == "PlannerError":
            print(f"hunav: {error}", file=sys.stderr)
            return FAILED
        # A planner of one's own may be named as module:Class, too.
        own = imports or ":" in (getattr(options, "planner", None) or "")
        fault = fault_of_user_code(error) if own else ""
        if not fault:
            raise
        print(f"hunav: {fault}", file=sys.stderr)
        return BAD_INPUT
    return code


def _show_warning(message: Warning | str, *_: object) -> None:
    print(f"hunav: warning: {message}", file=sys.stderr)


def _make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="hunav",
        description="Simulates people around robots, and measures how socially"
        " the robots navigate.",
    )
    commands = parser.add_subparsers(title="commands", required=True)
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
    return parser


if __name__ == "__main__":
    sys.exit(main())
