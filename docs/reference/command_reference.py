"""The page on the command `hunav`, made from its own help."""

import argparse
import re

from hunav_drake.commands.cli import _make_parser

HEAD = """# The command

`hunav` is in `.venv/bin` of a clone, or on the path where the package is
installed. It exits with 0 when done, 1 when the robot did not reach its goal,
and 2 for bad input, with a message in one line; `--debug` shows the traceback.
"""


def command_reference() -> str:
    """Returns the page, in Markdown."""
    return HEAD + "\n".join(_sections(_make_parser(), level=2)) + "\n"


def _sections(parser: argparse.ArgumentParser, level: int) -> list[str]:
    lines: list[str] = []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                lines += ["", f"{'#' * level} {command.prog}", ""]
                lines += ["```text", _help(command), "```"]
                lines += _sections(command, level + 1)
    return lines


def _help(parser: argparse.ArgumentParser) -> str:
    text = parser.format_help()
    return re.sub(r"\x1b\[[0-9;]*m", "", text).rstrip()
