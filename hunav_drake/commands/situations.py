"""The command `hunav situations`."""

import argparse
from pathlib import Path
import sys
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import DONE, input_errors

if TYPE_CHECKING:
    import pandas as pd

    from hunav_drake.systems.evaluation.situations import Situations


def add_situations_options(situations: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav situations`."""
    situations.description = (
        "Prints the social situations of a robot: how much of the time it is"
        " passing people, crossing their paths, joining a group, ..., and each"
        " episode. The file is any that `hunav evaluate` reads."
    )
    situations.set_defaults(function=_situations)
    situations.add_argument("file", type=Path, help="the recording")
    situations.add_argument(
        "--csv", action="store_true", help="print the episodes as CSV"
    )


def _situations(options: argparse.Namespace) -> int:
    from hunav_drake.runs.recording_files import ReadRecording
    from hunav_drake.systems.evaluation.situations import FindSituations

    with input_errors(ValueError):
        recording = ReadRecording(options.file)
    names = [it.robot_name for it in recording.robots]
    found = {it: FindSituations(recording, robot=it) for it in names}
    if options.csv:
        print(_csv(found), end="")
        return DONE
    parts = []
    for name, it in found.items():
        parts += [f"Robot {name}"] if recording.others else []
        parts += [_shares(it), _episodes(it.episodes())]
    print("\n\n".join(parts))
    if not recording.walls_known:
        print(
            "\nThe walls are unknown, so people behind walls count as near.",
            file=sys.stderr,
        )
    return DONE


def _csv(found: "dict[str, Situations]") -> str:
    """Returns the episodes as CSV, with a column of robots if several."""
    import pandas as pd

    tables = [it.episodes() for it in found.values()]
    if len(found) > 1:
        for name, table in zip(found, tables, strict=True):
            table.insert(0, "robot", name)
    text: str = pd.concat(tables).to_csv(index=False, float_format="%.9g")
    return text


def _shares(situations: "Situations") -> str:
    """Returns the labels that hold at some time, as a table."""
    table = situations.shares()
    table[["share", "primary"]] *= 100
    table = table[table["share"] > 0].reset_index()
    return _text(table, share="%", primary="%", episode_time="s")


def _episodes(table: "pd.DataFrame") -> str:
    if table.empty:
        return "No episodes."
    return _text(table, begin="s", end="s", least_gap="m", delay="s")


def _text(table: "pd.DataFrame", **units: str) -> str:
    """Returns a table for the terminal, with the units of columns."""
    # (Adding 0 takes away the sign of what rounds to 0.)
    table[list(units)] = table[list(units)].round(2) + 0.0
    heads = {it: f"{it.replace('_', ' ')} ({u})" for it, u in units.items()}
    text: str = table.rename(columns=heads).to_string(
        index=False, na_rep="-", float_format="{:.2f}".format
    )
    return text
