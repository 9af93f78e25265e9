"""The behaviors of each profile: their trees and leaves."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from hunav_drake.systems.behavior.hunavsim.leaves import hunavsim_node_types
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.nodes.registry import NODE_TYPES
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.people.profile import ProfileName

_FOLDER = Path(__file__).resolve().parent
_TREES, _HUNAVSIM_TREES = _FOLDER / "trees", _FOLDER / "hunavsim"
# Parts of trees, for users' trees; and whole ones of people with each other.
_BLOCKS, _ACTIVITIES = _FOLDER / "blocks", _FOLDER / "activities"

# The behaviors of HuNavSim.
_ORIGINAL = (
    *("regular", "impassive", "surprised"),
    *("scared", "curious", "threatening"),
)

# The file of each behavior that a `HumanConfig` can name.
BEHAVIORS: Mapping[str, Path] = MappingProxyType(
    {
        name: _TREES / f"{name}.xml"
        for name in (*_ORIGINAL, "distracted", "cooperative")
    }
)

# The file of each activity, which a `HumanConfig` can name, too: what people do
# with places and with each other.
ACTIVITIES: Mapping[str, Path] = MappingProxyType(
    {
        name: _ACTIVITIES / f"{name}.xml"
        for name in (
            *("sit", "queue", "errands", "lunch"),
            *("talk", "chat", "guide"),
        )
    }
)

# The other behaviors are those of the default profile.
_HUNAVSIM = {name: _HUNAVSIM_TREES / f"{name}.xml" for name in _ORIGINAL}


class BehaviorSet(NamedTuple):
    """The behaviors of a profile.

    Attributes:
        files: The files of behaviors, by name.
        folders: The folders in which users' trees find includes and subtrees,
            in order of precedence.
        node_types: Returns the node types, by name.
    """

    files: Mapping[str, Path]
    folders: tuple[Path, ...]
    node_types: Callable[[], Mapping[str, NodeType]]


_DEFAULT = BehaviorSet(
    {**BEHAVIORS, **ACTIVITIES}, (_TREES, _BLOCKS), lambda: NODE_TYPES
)
# The scared were pushed less, but by stronger forces of the robot, too.
_OLD = {**_DEFAULT.files, "scared": _FOLDER / "version_0_1" / "scared.xml"}

_SETS: Mapping[ProfileName, BehaviorSet] = MappingProxyType(
    {
        "default": _DEFAULT,
        "hunav_drake_0.1": _DEFAULT._replace(files=_OLD),
        "hunavsim": BehaviorSet(
            {**_DEFAULT.files, **_HUNAVSIM},
            (_HUNAVSIM_TREES, _TREES, _BLOCKS),
            hunavsim_node_types,
        ),
    }
)


def behavior_set(profile: ProfileName) -> BehaviorSet:
    """Returns the behaviors of a profile, which is chosen only here."""
    check_choice("profile", profile, _SETS)
    return _SETS[profile]
