"""The commands `hunav tree show`, `check` and `convert`."""

import argparse
import json
import textwrap

from hunav_drake.commands.errors import (
    DONE,
    check_each,
    input_errors,
    write_output,
)
from hunav_drake.commands.options import add_import_option, add_output_options
from hunav_drake.systems.common.suggest import counted


def add_tree_options(tree: argparse.ArgumentParser) -> None:
    """Adds the commands of `hunav tree`."""
    actions = tree.add_subparsers(title="commands", required=True)
    file_help = "a tree file, or the name of a behavior"

    show = actions.add_parser(
        "show", help="show a tree, its ports and its memory"
    )
    show.set_defaults(function=_show)
    show.add_argument("file", help=file_help)

    check = actions.add_parser("check", help="check tree files")
    check.set_defaults(function=_check)
    check.add_argument("file", nargs="+", help=file_help)

    convert = actions.add_parser(
        "convert", help="convert a tree to format 4 of BehaviorTree.CPP"
    )
    convert.set_defaults(function=_convert)
    convert.add_argument("file", help=file_help)
    add_output_options(convert)
    for command in (show, check, convert):
        add_import_option(command)


def _show(options: argparse.Namespace) -> int:
    """Prints a tree, its ports, and the layout of its memory."""
    from hunav_drake.systems.behavior import (
        BehaviorTreeError,
        LoadTree,
        RenderBehaviorTree,
    )
    from hunav_drake.systems.behavior.port_words import port_entries

    with input_errors(BehaviorTreeError):
        tree = LoadTree(options.file)
    print(f"{tree.name} ({tree.file})\n")
    # Each line is a node.
    for i, line in enumerate(str(RenderBehaviorTree(tree)).splitlines()):
        print(f"{i:3d}  {line}")
    if ports := port_entries(tree):
        print("\nPorts:")
        for port in ports:
            value = "required"
            if not port["required"]:
                value = json.dumps(port["default"], ensure_ascii=False)
            unit = port["schema"].get("x-unit", "")
            print(f"  {port['name']}  {value} {unit}".rstrip())
            words = textwrap.wrap(port["help"], 72)
            print("".join(f"      {line}\n" for line in words), end="")
    print()
    description = tree.Describe()
    print(description[description.index("Memory:") :])
    return DONE


def _check(options: argparse.Namespace) -> int:
    """Checks tree files, and prints the first error of each."""
    from hunav_drake.systems.behavior import BehaviorTreeError, LoadTree

    def describe(file: str) -> str:
        with input_errors(BehaviorTreeError):
            tree = LoadTree(file)
        return (
            f"{tree.name}, {counted(len(tree.nodes), 'node')},"
            f" {counted(len(tree.slots), 'number')} of memory"
        )

    return check_each(options.file, options, describe)


def _convert(options: argparse.Namespace) -> int:
    """Writes a tree in format 4 of BehaviorTree.CPP."""
    from hunav_drake.systems.behavior import BehaviorTreeError, ConvertTree

    with input_errors(BehaviorTreeError):
        text = ConvertTree(options.file)
    return write_output(text, options, f"Wrote {options.output}")
