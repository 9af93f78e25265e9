"""The ports of trees: the values that users of a tree can set.

The TreeNodesModel of a file declares the ports of its trees, as in Groot2::

    <SubTree ID="CuriousNavTree">
      <input_port name="distance" type="double" default="10.0"/>
    </SubTree>

In the tree a port is a blackboard entry, here `{distance}`.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import math
from typing import Any

from hunav_drake.systems.behavior.language.blackboard import GIVEN
from hunav_drake.systems.behavior.language.xml_source import XmlElement
from hunav_drake.systems.behavior.nodes.errors import (
    BehaviorTreeError,
    Place,
    Spot,
)

_PORT_TAGS = ("input_port", "inout_port")

# The Python types that a type in XML accepts; any other type accepts all.
_RULES: Mapping[str, tuple[tuple[type, ...], str]] = {
    "double": ((int, float), "a number"),
    "float": ((int, float), "a number"),
    "int": ((int,), "a whole number"),
    "bool": ((bool,), "true or false"),
    "std::string": ((str,), "a text"),
}
_ANY = ((int, float, bool, str), "a number, a text, true or false")


@dataclass(frozen=True)
class TreePort:
    """A port of a tree.

    Attributes:
        name: Its name, and that of its blackboard entry.
        type: The name of its type in C++, as Groot2 writes it; or nothing.
        default: Its value if nothing sets it, as text; None if it must be set.
        place: Where it is declared.
    """

    name: str
    type: str
    default: str | None
    place: Place


class TreePortError(BehaviorTreeError):
    """An invalid value for a port of a tree.

    Attributes:
        port: The name of the port.
    """

    def __init__(
        self,
        message: str,
        place: Place,
        *,
        port: str,
        nearest: str | None = None,
    ) -> None:
        super().__init__(message, place, nearest=nearest)
        self.port = port
        # Without the place of the tree.
        self.message = message


def declared_ports(
    models: Iterable[XmlElement],
) -> dict[str, dict[str, TreePort]]:
    """Returns the ports, by tree and name, that <TreeNodesModel>s declare."""
    result: dict[str, dict[str, TreePort]] = {}
    for model in models:
        for tree in model.children:
            if tree.tag != "SubTree" or "ID" not in tree.attributes:
                continue
            ports = result.setdefault(tree.attributes["ID"], {})
            for element in tree.children:
                name = element.attributes.get("name")
                if element.tag in _PORT_TAGS and name:
                    # (Groot2 writes an empty default for none.)
                    kind = element.attributes.get("type", "")
                    default = element.attributes.get("default")
                    if not default and kind != "std::string":
                        default = None
                    ports[name] = TreePort(name, kind, default, element.place)
    return result


def port_texts(
    ports: Mapping[str, TreePort], values: Mapping[str, Any], place: Place
) -> dict[str, str]:
    """Returns values for the ports of a tree as text in XML, by port.

    Raises:
        TreePortError: At the first value without a port, or of a wrong type.
    """
    return {
        name: _port_text(ports, name, value, place)
        for name, value in values.items()
    }


def _port_text(
    ports: Mapping[str, TreePort], name: str, value: Any, place: Place
) -> str:
    if name in GIVEN:
        raise TreePortError(
            f"{name} cannot be set: {GIVEN[name]}", place, port=name
        )
    port = ports.get(name)
    if port is None:
        error = Spot(place).unknown("port", name, ports)
        raise TreePortError(
            error.message, place, port=name, nearest=error.nearest
        )
    types, rule = _RULES.get(port.type, _ANY)
    fits = isinstance(value, types)
    if isinstance(value, bool):
        fits = bool in types
    if not fits or (isinstance(value, float) and not math.isfinite(value)):
        text = repr(value)
        if len(text) > 60:
            text = text[:57] + "..."
        raise TreePortError(f"must be {rule}, got {text}", place, port=name)
    if isinstance(value, bool):
        return "true" if value else "false"
    try:
        return str(value)
    except ValueError as error:
        # Python does not write integers of more than 4300 digits.
        raise TreePortError(
            f"must be {rule}, got a number too large", place, port=name
        ) from error
