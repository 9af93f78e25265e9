"""The choice of a person's behavior tree and its ports."""

from collections.abc import Mapping
from dataclasses import field
from pathlib import PurePath
from typing import Annotated, Any

from pydantic import Discriminator, StrictStr, Tag, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs, PydanticCustomError

from hunav_drake.systems.common.old_words import TAG, twice, with_tag
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG


# Any key may be the name of a port.
@plain_errors
@dataclass(
    kw_only=True,
    config=CONFIG | {"json_schema_extra": {"additionalProperties": True}},
)
class BehaviorConfig:
    """A behavior tree, and values for its ports.

    In a scenario file the ports stand beside the type::

        behavior: {type: curious, distance: 6.0, duration: 10}
    """

    type: StrictStr
    """Behavior tree: a name, the path of a file, or XML; see `HumanConfig`."""

    ports: dict[StrictStr, Any] = field(default_factory=dict)
    """Values (numbers, texts, booleans) by the names of the tree's ports; other
    ports have the defaults that the tree declares."""

    @model_validator(mode="before")
    @classmethod
    def _gather_ports(cls, data: Any) -> Any:
        if isinstance(data, ArgsKwargs):
            given = with_tag("behavior", data.kwargs or {})
            return ArgsKwargs(data.args, given)
        if not isinstance(data, Mapping):
            return data
        data = with_tag("behavior", data)
        if fault := twice("behavior", data):
            raise _error(f"tree {fault}")
        ports = {key: value for key, value in data.items() if key != TAG}
        if isinstance(ports.get("ports"), Mapping):
            own = ports.pop("ports")
            again = [str(name) for name in own if name in ports]
            if again:
                raise _error(
                    f"the port {again[0]} is given twice, beside the type and"
                    " in ports; remove one of them"
                )
            ports |= own
        tag = {TAG: data[TAG]} if TAG in data else {}
        return {**tag, "ports": ports}

    @property
    def tree(self) -> str:
        """The old word for `type`."""
        return self.type


def _error(rule: str) -> PydanticCustomError:
    return PydanticCustomError("rule", "{rule}", {"rule": rule})


def _kind(behavior: Any) -> str:
    # The tags that pydantic puts into the places of errors.
    is_config = isinstance(behavior, Mapping | BehaviorConfig)
    return "behaviorconfig" if is_config else "str"


Behavior = Annotated[
    Annotated[StrictStr, Tag("str")]
    | Annotated[BehaviorConfig, Tag("behaviorconfig")],
    Discriminator(_kind),
]


def tree_of(behavior: str | BehaviorConfig) -> str:
    """Returns the name, path or XML of a behavior's tree."""
    return behavior if isinstance(behavior, str) else behavior.type


def is_xml(tree: str) -> bool:
    """Returns whether a tree is given as XML."""
    return tree.lstrip().startswith("<")


def is_path(tree: str) -> bool:
    """Returns whether a tree is given as the path of a file."""
    return not is_xml(tree) and tree.endswith(".xml")


def behavior_name(behavior: str | BehaviorConfig) -> str:
    """Returns the name of a behavior in tables."""
    tree = tree_of(behavior)
    if is_xml(tree):
        return "xml"
    return PurePath(tree).stem if is_path(tree) else tree
