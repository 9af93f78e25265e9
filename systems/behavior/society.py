"""What social leaves know of everybody: numbers of people, and places."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.behavior.nodes.node import Node
from hunav_drake.systems.behavior.nodes.port import Constant, Meaning
from hunav_drake.systems.behavior.nodes.social import LIST_SIZE, PLACE_SIZE
from hunav_drake.systems.behavior.nodes.texts import (
    people_code,
    people_of,
    place_code,
    text_code,
)
from hunav_drake.systems.behavior.nodes.tick_context import Person
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import MAX_PARTNERS
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.people.places import Place


class _HasNodes(Protocol):
    nodes: tuple[Node, ...]


@dataclass(frozen=True, eq=False)
class Society:
    """What the social leaves of trees know, in tables for compiled code.

    Attributes:
        ids: Shape (n,): the number of each person.
        places: A row for each place: its two codes, and its pose in W.
        lists: A row for each list of people in the trees: its code, the number
            of people, and their rows.
    """

    ids: NDArray[np.int64]
    places: Array
    lists: Array

    @classmethod
    def of(
        cls,
        trees: Sequence[_HasNodes],
        people: Sequence[Person],
        ids: Sequence[int],
        places: Sequence[Place],
    ) -> "Society":
        """Makes the tables, and checks all that the trees name.

        Args:
            trees: The trees.
            people: The person that ticks each of them.
            ids: The numbers of all people.
            places: All places, with names and numbers.

        Raises:
            BehaviorTreeError: If a tree names a person or place that is not
                there, or too many people.
        """
        rows = {number: row for row, number in enumerate(ids)}
        lists: dict[float, list[float]] = {}
        for tree, person in zip(trees, people, strict=True):
            for node, name, value in _named(tree):
                meaning = node.type.ports[name].meaning
                if meaning is Meaning.PLACE:
                    _check_place(node, name, value, places)
                    continue
                numbers = (
                    people_of(value) if meaning is Meaning.PEOPLE else (value,)
                )
                _check_people(node, name, numbers, person, rows)
                if len(numbers) > 1:
                    own = [rows[number] for number in numbers]
                    own += [-1] * (MAX_PARTNERS - len(own))
                    code = people_code(value)
                    lists[code] = [code, len(numbers), *own]
        return cls(
            np.array(ids, dtype=np.int64),
            np.array(
                [
                    (place_code(f"{it.id}"), text_code(it.name), *it.pose)
                    for it in places
                ],
                dtype=float,
            ).reshape(-1, PLACE_SIZE),
            np.array([*lists.values()], dtype=float).reshape(-1, LIST_SIZE),
        )


def _named(tree: _HasNodes) -> Iterator[tuple[Node, str, Any]]:
    """Yields the ports of nodes that name people or places, and what."""
    for node in tree.nodes:
        for name, value in node.ports.items():
            meaning = node.type.ports[name].meaning
            if not isinstance(value, Constant) or value.value in (-1, ""):
                continue
            if meaning not in (None, Meaning.RESULT):
                yield node, name, value.value


def _check_place(
    node: Node, port: str, name: str, places: Sequence[Place]
) -> None:
    names = [it.name for it in places]
    if name.strip() not in (*names, *(f"{it.id}" for it in places)):
        raise node.error(
            f"port {port}: there is no place {name.strip()!r}"
            f"{did_you_mean(name, names)}; add it to places"
        )


def _check_people(
    node: Node,
    port: str,
    numbers: Sequence[int],
    person: Person,
    rows: dict[int, int],
) -> None:
    for number in numbers:
        if number not in rows:
            known = ", ".join(map(str, [*rows][:10]))
            raise node.error(
                f"port {port}: nobody has the number {number}; there"
                f" {'are' if len(rows) > 1 else 'is'} {known}"
            )
    if len(numbers) > MAX_PARTNERS or len(set(numbers)) < len(numbers):
        raise node.error(
            f"port {port}: must be at most {MAX_PARTNERS} different numbers,"
            f" got {len(numbers)}"
        )
    if port == "main_agent_id" and numbers != (person.id,):
        raise node.error(
            f"port {port}: must be the person's own number {person.id}, as a"
            f" tree moves its own person only, got {numbers[0]}"
        )
