"""What `hunav tree` does: shows, checks and converts behavior trees."""

from collections.abc import Sequence
import errno
from pathlib import Path
import sys

from hunav_drake.systems.behavior import (
    BehaviorTreeError,
    ConvertTree,
    LoadTree,
    RenderBehaviorTree,
)
from hunav_drake.systems.files import atomic_write

# The exit codes.
DONE, BAD_INPUT = 0, 2


def show(file: str) -> int:
    """Prints a tree, the layout of its memory, and its ports.

    Args:
        file: The path of a tree file, or the name of a behavior.

    Returns:
        0.

    Raises:
        BehaviorTreeError: At the first fault in the tree.
    """
    tree = LoadTree(file)
    print(f"{tree.name} ({tree.file})\n")
    # Each line is a node.
    for i, line in enumerate(str(RenderBehaviorTree(tree)).splitlines()):
        print(f"{i:3d}  {line}")
    ports = tree.documents.main_ports()
    if ports:
        print("\nPorts:")
        width = max(map(len, ports))
        for name, port in ports.items():
            default = "must be given" if port.default is None else port.default
            print(f"  {name:{width}}  {default}")
    print()
    description = tree.Describe()
    print(description[description.index("Memory:") :])
    return DONE


def check(files: Sequence[str]) -> int:
    """Tells for each file whether it is a tree, and else its first fault.

    Args:
        files: Paths of tree files, or names of behaviors.

    Returns:
        0 if all are trees, else 2.
    """
    code = DONE
    for file in files:
        try:
            tree = LoadTree(file)
        except BehaviorTreeError as error:
            print(error, file=sys.stderr)
            code = BAD_INPUT
        else:
            print(
                f"{file}: ok ({tree.name}, {len(tree.nodes)}"
                f" {'node' if len(tree.nodes) == 1 else 'nodes'},"
                f" {len(tree.slots)} numbers of memory)"
            )
    return code


def convert(
    file: str, output: Path | None = None, *, force: bool = False
) -> int:
    """Writes a tree in format 4 of BehaviorTree.CPP.

    Args:
        file: The path of a tree file in format 3 or 4, or the name of a
            behavior.
        output: The file to write; None to print.
        force: Whether to write over an existing file.

    Returns:
        0.

    Raises:
        BehaviorTreeError: At the first fault in the tree.
        FileExistsError: If there is such a file, and not ``force``.
        OSError: If the file cannot be written.
    """
    text = ConvertTree(file)
    if output is None:
        print(text, end="")
        return DONE
    if output.exists() and not force:
        raise FileExistsError(errno.EEXIST, "exists already", str(output))
    with atomic_write(output) as stream:
        stream.write(text.encode())
    print(f"Wrote {output}")
    return DONE
