"""The behaviors that come with the package, and how to load trees."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

# The leaves register themselves.
from hunav_drake.systems.behavior import leaves as _leaves  # noqa: F401
from hunav_drake.systems.behavior.documents import (
    is_file,
    load_documents,
    read_file,
)
from hunav_drake.systems.behavior.errors import Place, unknown
from hunav_drake.systems.behavior.parser import parse_documents
from hunav_drake.systems.behavior.tree import Tree

_FOLDER = Path(__file__).resolve().parent / "trees"

# The file of each behavior that a `HumanConfig` can name.
BEHAVIORS: Mapping[str, Path] = MappingProxyType(
    {name: _FOLDER / f"{name}.xml" for name in ("regular", "impassive")}
)


def LoadTree(name_or_path: str | Path) -> Tree:
    """Loads a behavior that comes with the package, or a tree from a file.

    Args:
        name_or_path: One of `BEHAVIORS`, or the path of an XML file in the
            format 3 or 4 of BehaviorTree.CPP.

    Raises:
        BehaviorTreeError: If there is no such behavior or file, or at the
            first fault in the file.
    """
    path = BEHAVIORS.get(str(name_or_path), Path(name_or_path))
    if not is_file(path):
        raise unknown(
            "behavior or file",
            str(name_or_path),
            BEHAVIORS,
            Place(str(name_or_path)),
            "",
        )
    documents = load_documents(read_file(path), str(path), path.parent)
    return Tree(parse_documents(documents), str(path))


def ParseTree(source: str | bytes, *, name: str = "<text>") -> Tree:
    """Makes a tree from XML.

    Args:
        source: The XML, in the format 3 or 4 of BehaviorTree.CPP.
        name: What stands for the source in messages.

    Raises:
        BehaviorTreeError: At the first fault in the source.
    """
    if isinstance(source, str):
        source = source.encode()
    return Tree(parse_documents(load_documents(source, name)), name)
