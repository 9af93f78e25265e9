"""Loads trees: the behaviors of this package, and trees from files or text."""

from collections.abc import Iterable, Iterator, Mapping
import functools
import os
from pathlib import Path
from types import MappingProxyType
from typing import Any

# The leaves register themselves.
from hunav_drake.systems.behavior import leaves as _leaves  # noqa: F401
from hunav_drake.systems.behavior.language.documents import (
    Documents,
    load_documents,
    read_file,
)
from hunav_drake.systems.behavior.language.parser import parse_documents
from hunav_drake.systems.behavior.language.tree_ports import (
    TreePortError,
    port_texts,
)
from hunav_drake.systems.behavior.nodes.errors import (
    BehaviorTreeError,
    Place,
    Spot,
)
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.profiles import (
    ACTIVITIES,
    BEHAVIORS,
    behavior_set,
)
from hunav_drake.systems.behavior.society import spoken_texts
from hunav_drake.systems.behavior.tree import Tree
from hunav_drake.systems.people.behavior_choice import (
    BehaviorConfig,
    is_path,
    is_xml,
)
from hunav_drake.systems.people.profile import ProfileName

__all__ = [
    "ACTIVITIES",
    "BEHAVIORS",
    "CheckBehavior",
    "LoadBehavior",
    "LoadBehaviors",
    "LoadTree",
    "ParseTree",
]

# A behavior with more faults is not looked through to its end.
MAX_FAULTS = 20

_NO_PORTS: Mapping[str, Any] = MappingProxyType({})


def LoadTree(
    name_or_path: str | Path,
    ports: Mapping[str, Any] = _NO_PORTS,
    *,
    allow_outside: bool = False,
    profile: ProfileName = "default",
) -> Tree:
    """Loads a behavior that comes with the package, or a tree from a file.

    A user's file may include files of the package, as in
    ``<include path="regular.xml"/>``, or use their trees as subtrees without
    including them, as in ``<SubTree ID="RegularNavTree"/>``.

    Args:
        name_or_path: One of `BEHAVIORS` or `ACTIVITIES`, or the path of an XML
            file in the format 3 or 4 of BehaviorTree.CPP.
        ports: Values for ports of the tree: numbers, texts, booleans. The
            others have the defaults that the file declares.
        allow_outside: Whether the file may include files that are not in its
            folder or below. Leave it False for a tree from elsewhere, which
            could make any file be read.
        profile: The profile whose behaviors and leaves are used, also in
            subtrees: see `profiles.py`.

    Raises:
        BehaviorTreeError: If there is no such behavior or file, or at the
            first fault in the file.
        TreePortError: If the tree has no port of a name, or a value does not
            fit it.
    """
    files = behavior_set(profile).files
    name = str(name_or_path)
    path = files.get(name, Path(name_or_path))
    if path == BEHAVIORS.get(name):
        # A behavior that the profile lacks is the default one, with its leaves.
        profile = "default"
    if not os.path.isfile(path):
        raise Spot(Place(name)).unknown("behavior or file", name, files)
    folders = behavior_set(profile).folders
    # (Files of the package stay as they are.)
    load = _load_own if name in files else _load
    return _tree(load(path, folders, allow_outside), ports, profile)


def _load(
    path: Path, folders: tuple[Path, ...], allow_outside: bool
) -> Documents:
    """Reads a file and those that it includes."""
    return load_documents(
        read_file(path),
        str(path),
        path.parent,
        libraries=folders,
        allow_outside=allow_outside,
    )


_load_own = functools.cache(_load)


def ParseTree(
    source: str | bytes,
    *,
    name: str = "<text>",
    ports: Mapping[str, Any] = _NO_PORTS,
    profile: ProfileName = "default",
) -> Tree:
    """Makes a tree from XML.

    It may include files of the package and use their trees as subtrees, as
    for `LoadTree`.

    Args:
        source: The XML, in the format 3 or 4 of BehaviorTree.CPP.
        name: The name of the source in messages.
        ports: Values for ports of the tree, as for `LoadTree`.
        profile: As for `LoadTree`.

    Raises:
        BehaviorTreeError: At the first fault in the source.
        TreePortError: As `LoadTree`.
    """
    if isinstance(source, str):
        # (What is no character is a fault in XML, not in Python.)
        source = source.encode(errors="xmlcharrefreplace")
    folders = behavior_set(profile).folders
    documents = load_documents(source, name, libraries=folders)
    return _tree(documents, ports, profile)


def LoadBehavior(
    behavior: str | BehaviorConfig, *, profile: ProfileName = "default"
) -> Tree:
    """Loads the tree of a person's configuration.

    Args:
        behavior: As `HumanConfig.behavior`.
        profile: The profile whose behaviors and leaves are used, as in
            `CrowdConfig`.

    Raises:
        BehaviorTreeError: If there is no such tree, or at the first fault in
            it.
        TreePortError: At the first invalid value for a port.
    """
    if isinstance(behavior, str):
        behavior = BehaviorConfig(type=behavior)
    if is_xml(behavior.type):
        return ParseTree(
            behavior.type,
            name="behavior",
            ports=behavior.ports,
            profile=profile,
        )
    if is_path(behavior.type):
        if not os.path.isfile(behavior.type):
            raise BehaviorTreeError(
                "there is no such file", Place(behavior.type)
            )
    elif behavior.type not in (known := behavior_set(profile).files):
        # Any other word is meant as a name, even where there is such a file.
        place = Place("behavior")
        raise Spot(place).unknown("behavior", behavior.type, known)
    return LoadTree(behavior.type, behavior.ports, profile=profile)


def LoadBehaviors(
    behaviors: Iterable[str | BehaviorConfig],
    *,
    profile: ProfileName = "default",
) -> list[Tree]:
    """Loads the trees of several people, each behavior once.

    Args:
        behaviors: Each as `HumanConfig.behavior`.
        profile: As for `LoadBehavior`.

    Raises:
        BehaviorTreeError: As `LoadBehavior`.
    """
    all_behaviors = list(behaviors)
    distinct = {repr(behavior): behavior for behavior in all_behaviors}
    trees = {
        key: LoadBehavior(it, profile=profile) for key, it in distinct.items()
    }
    return [trees[repr(behavior)] for behavior in all_behaviors]


def sayings_of(
    behaviors: Iterable[str | BehaviorConfig],
    *,
    profile: ProfileName = "default",
) -> list[dict[float, str]]:
    """Returns the texts that each of several people may say, by `text_code`.

    The arguments and errors are those of `LoadBehaviors`.
    """
    return [*map(spoken_texts, LoadBehaviors(behaviors, profile=profile))]


def CheckBehavior(
    behavior: str | BehaviorConfig, *, profile: ProfileName = "default"
) -> Iterator[BehaviorTreeError]:
    """Finds the faults of a behavior.

    Args:
        behavior: As `HumanConfig.behavior`.
        profile: As for `LoadBehavior`.

    Returns:
        The first fault of its tree, or else a TreePortError for each invalid
        value for a port.
    """
    if isinstance(behavior, str):
        behavior = BehaviorConfig(type=behavior)
    ports = dict(behavior.ports)
    for _ in range(MAX_FAULTS):
        try:
            LoadBehavior(
                BehaviorConfig(type=behavior.type, ports=ports), profile=profile
            )
        except TreePortError as error:
            yield error
            if error.port not in ports:
                return
            del ports[error.port]
        except BehaviorTreeError as error:
            yield error
            return
        else:
            return


def _tree(
    documents: Documents, values: Mapping[str, Any], profile: ProfileName
) -> Tree:
    ports = documents.main_ports()
    texts = port_texts(ports, values, Place(documents.file))
    for name, port in ports.items():
        if port.default is None and name not in texts:
            raise TreePortError(
                f"the tree needs a value for {name}", port.place, port=name
            )
    node_types = tuple(behavior_set(profile).node_types().values())
    return _parse(documents, tuple(texts.items()), node_types)


@functools.lru_cache(maxsize=128)
def _parse(
    documents: Documents,
    values: tuple[tuple[str, str], ...],
    node_types: tuple[NodeType, ...],
) -> Tree:
    """Returns the tree of documents, from a cache if it was parsed before.

    The key has all registered node types: a tree keeps the leaves of its time,
    so a leaf that is registered again needs a new tree.
    """
    ports = documents.main_ports()
    texts = dict(values)
    try:
        return Tree(parse_documents(documents, texts, node_types))
    except BehaviorTreeError as error:
        # A value that a node refuses is a fault of the value.
        for name in texts:
            alone = {
                other: text
                for other, text in texts.items()
                if other == name or ports[other].default is None
            }
            without = {**alone, name: ports[name].default or texts[name]}
            if _parses(documents, without, node_types) and not _parses(
                documents, alone, node_types
            ):
                place = Place(documents.file)
                raise TreePortError(error.message, place, port=name) from error
        raise


def _parses(
    documents: Documents,
    texts: Mapping[str, str],
    node_types: tuple[NodeType, ...],
) -> bool:
    try:
        Tree(parse_documents(documents, texts, node_types))
    except BehaviorTreeError:
        return False
    return True
