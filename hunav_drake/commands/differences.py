"""The command `hunav differences`."""

import argparse
import json

from hunav_drake.commands.errors import write_output
from hunav_drake.commands.options import add_output_options


def add_differences_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav differences`."""
    parser.set_defaults(function=_differences)
    form = parser.add_mutually_exclusive_group()
    form.add_argument(
        "--json", action="store_true", help="print the list as JSON"
    )
    form.add_argument(
        "--markdown", action="store_true", help="print a page of Markdown"
    )
    form.add_argument(
        "--left",
        action="store_true",
        help="only the differences that remain with crowd.profile hunavsim",
    )
    add_output_options(parser)


def _differences(options: argparse.Namespace) -> int:
    from hunav_drake.hunavsim import differences

    if options.json:
        text = json.dumps(differences.as_data(), indent=2) + "\n"
    elif options.markdown:
        text = differences.as_markdown()
    elif options.left:
        text = differences.as_text(differences.left_by_profile()) + "\n"
    else:
        text = differences.as_text() + "\n"
    return write_output(text, options, f"Wrote the list to {options.output}")
