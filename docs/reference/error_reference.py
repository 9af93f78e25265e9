"""The page on errors: common mistakes, and what the program says of them."""

from collections.abc import Iterator
import contextlib
import io
from pathlib import Path
import re
import shlex
import sys
import tempfile

from hunav_drake.commands import cli

# The mistakes are those that the tests make.
sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.hunav_drake.test_common_mistakes import COMMANDS, ROOM, YAML

HEAD = """# Errors

Bad input is told in one line: the place, the rule, what was found, and what
helps. A file is checked as a whole, so all its faults come at once, with their
lines. These are common mistakes and what is said of each.
"""


def error_reference() -> str:
    """Returns the page, in Markdown."""
    lines = [HEAD, "## In a scenario file", ""]
    lines += ["| mistake | what is written | what is said |"]
    lines += ["| --- | --- | --- |"]
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for mistake, (old, new, _) in YAML.items():
            Path("room.yaml").write_text(ROOM.replace(old, new))
            lines.append(_row(mistake, new, _said(["check", "room.yaml"])))
        lines += ["", "## In a command", ""]
        lines += ["| mistake | command | what is said |"]
        lines += ["| --- | --- | --- |"]
        for mistake, (command, _) in COMMANDS.items():
            said = _said(shlex.split(command))
            lines.append(_row(mistake, f"hunav {command}", said))
    return "\n".join(lines) + "\n"


def _row(mistake: str, written: str, said: str) -> str:
    shown = " ".join(written.split()) or "(nothing)"
    cells = (mistake, f"`{shown}`", f"`{said}`")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _said(words: list[str]) -> str:
    """Returns the line of the command that tells the fault."""
    output = io.StringIO()
    with (
        contextlib.redirect_stderr(output),
        contextlib.redirect_stdout(output),
        contextlib.suppress(SystemExit),
    ):
        cli.main(words)
    lines = list(_told(output.getvalue()))
    return lines[0] if lines else output.getvalue().strip()


def _told(text: str) -> Iterator[str]:
    """Yields the lines that tell a fault, those with a place first."""
    lines = [line.removeprefix("hunav: ") for line in text.splitlines()]
    yield from (it for it in lines if re.match(r"\S+:\d+: ", it))
    yield from (it for it in lines if ":" in it and "usage:" not in it)
