"""The command `hunav situations`."""

import argparse
from pathlib import Path
import sys
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import DONE, input_errors

if TYPE_CHECKING:
    import pandas as pd


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
        "--door",
        action="append",
        metavar="X,Y",
        help="the middle of a door, in meters, as --door=-2,0 (repeatable);"
        " by default those that the recording knows",
    )
    situations.add_argument(
        "--csv", action="store_true", help="print the episodes as CSV"
    )


def _situations(options: argparse.Namespace) -> int:
    from hunav_drake.runs.recording_files import ReadRecording
    from hunav_drake.systems.evaluation.situations import FindSituations

    with input_errors(ValueError):
        recording = ReadRecording(options.file)
        doors = options.door and [it.split(",") for it in options.door]
        names = [it.robot_name for it in recording.robots]
        found = {
            it: FindSituations(recording, robot=it, doors=doors) for it in names
        }
    episodes = _joined({name: it.episodes() for name, it in found.items()})
    if options.csv:
        print(episodes.to_csv(index=False, float_format="%.9g"), end="")
        return DONE
    shares = _joined(
        {name: it.shares().reset_index() for name, it in found.items()}
    )
    shares[["share", "primary"]] *= 100
    shares = shares[shares["share"] > 0]
    print(_text(shares, share="%", primary="%", episode_time="s"), end="\n\n")
    print(_text(episodes, begin="s", end="s", least_gap="m", delay="s"))
    if not recording.walls_known:
        print(
            "\nThe walls are unknown, so people behind walls count as near.",
            file=sys.stderr,
        )
    return DONE


def _joined(tables: "dict[str, pd.DataFrame]") -> "pd.DataFrame":
    """Returns the tables of all robots; several have a column of names."""
    import pandas as pd

    if len(tables) == 1:
        return next(iter(tables.values()))
    return pd.concat(tables, names=["robot"]).reset_index("robot")


def _text(table: "pd.DataFrame", **units: str) -> str:
    """Returns a table for the terminal, with the units of columns."""
    if table.empty:
        return "No episodes."
    # (Adding 0 takes away the sign of what rounds to 0.)
    rounded = table[list(units)].round(2) + 0.0
    heads = {it: f"{it.replace('_', ' ')} ({u})" for it, u in units.items()}
    text: str = (
        table.assign(**rounded)
        .rename(columns=heads)
        .to_string(index=False, na_rep="-", float_format="{:.2f}".format)
    )
    return text
