"""What social leaves know of everybody: numbers of people, and places."""

from collections.abc import Collection, Container, Iterator, Sequence
from dataclasses import dataclass
import functools
import hashlib
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.behavior.nodes.node import Node
from hunav_drake.systems.behavior.nodes.port import Constant, Meaning, Port
from hunav_drake.systems.behavior.nodes.social import LIST_SIZE, SEAT_TYPES
from hunav_drake.systems.behavior.nodes.texts import (
    people_code,
    people_of,
    place_code,
    text_code,
)
from hunav_drake.systems.behavior.nodes.tick import PLACE_SIZE, SLOT_SIZE
from hunav_drake.systems.behavior.nodes.tick_context import Person
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import MAX_PARTNERS
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.people.places import PLACE_TYPES, Place


class _HasNodes(Protocol):
    nodes: tuple[Node, ...]


@dataclass(frozen=True, kw_only=True)
class SocialOptions:
    """What trees with social leaves need to know.

    Attributes:
        places: The places that they name; those without a name or number get
            one.
        signals: Whether there are ports for signals also if no tree of the
            system has social leaves.
        seed: The seed in the default Context, in [0, 2^63), of what people do
            by chance.
    """

    places: Sequence[Place] = ()
    signals: bool = False
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Society:
    """What the social leaves of trees know, in tables for compiled code.

    Attributes:
        ids: Shape (n,): the number of each person.
        places: A row of `PLACE_SIZE` for each place.
        slots: A row of `SLOT_SIZE` for each slot of all places: its pose
            (x, y, yaw) in W, where people stand before they use it (x, y), and
            the rows of the place, and of the slot in it.
        lists: A row for each list of people in the trees: its code, the number
            of people, and their rows.
    """

    ids: NDArray[np.int64]
    places: Array
    slots: Array
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
            check_named(tree, [person.id], rows, places, person.needs)
            for _, _, numbers in _named(tree, Meaning.PEOPLE):
                if len(numbers) > 1:
                    own = [rows[number] for number in numbers]
                    own += [-1] * (MAX_PARTNERS - len(own))
                    code = people_code(", ".join(map(str, numbers)))
                    lists[code] = [code, len(numbers), *own]
        slots: list[tuple[float, ...]] = []
        table = []
        for row, it in enumerate(places):
            own_slots = it.all_slots()
            kind = PLACE_TYPES.index(it.type)
            table.append(
                [
                    *(place_code(f"{it.id}"), text_code(it.name), *it.pose),
                    *(it.spacing, it.time, kind, len(slots), len(own_slots)),
                    *(*it.way_to(), it.width),
                ]
            )
            slots += [
                (*slot, *before, row, k)
                for k, (slot, before) in enumerate(
                    zip(own_slots, it.all_approaches(), strict=True)
                )
            ]
        return cls(
            np.array(ids, dtype=np.int64),
            np.array(table, dtype=float).reshape(-1, PLACE_SIZE),
            np.array(slots, dtype=float).reshape(-1, SLOT_SIZE),
            np.array([*lists.values()], dtype=float).reshape(-1, LIST_SIZE),
        )

    @functools.cached_property
    def slots_beside(self) -> Array:
        """The slots of people in wheelchairs: beside seats and beds."""
        slots = self.slots.copy()
        kinds = self.places[slots[:, 5].astype(int), 7]
        sits = np.isin(kinds, SEAT_TYPES)
        slots[sits, :2] = slots[sits, 3:5]
        return slots

    def describe_places(self) -> str:
        """Returns which places there are, but not where: rows have memory."""
        which = self.places[:, [0, 1, 7, 8, 9]]
        digest = hashlib.sha256(which.tobytes()).hexdigest()
        return f"of {len(which)} places ({digest[:8]})"


def check_named(
    tree: _HasNodes,
    own: Collection[int],
    ids: Container[int],
    places: Sequence[Place],
    needs: Collection[str],
) -> None:
    """Checks that people, places and needs that a tree names are there.

    Args:
        tree: The tree.
        own: The numbers of the people that tick it.
        ids: The numbers of all people.
        places: All places, with names and numbers.
        needs: The needs of these people.

    Raises:
        BehaviorTreeError: If a person, place or need is not there, or a leaf is
            to act for another person.
    """
    for node in tree.nodes:
        others = [it for it in own if node.owner not in (None, it)]
        if others:
            raise node.error(
                f"it is to act for person {node.owner}, but this is the tree"
                f" of person {others[0]}; leave the number out"
            )
    names = [it.name for it in places]
    known = {key: it for it in places for key in (it.name, f"{it.id}")}
    for meaning in (Meaning.PLACE, Meaning.DOOR):
        for node, port, (name,) in _named(tree, meaning):
            place = known.get(name.strip())
            if place is None:
                raise node.error(
                    f"port {port}: there is no place {name.strip()!r}; add it"
                    f" to places{did_you_mean(name, names)}"
                )
            if meaning is Meaning.DOOR and place.type != "door":
                raise node.error(
                    f"port {port}: must be a door, but {place.name!r} is a"
                    f" {place.type}; give the place the type door"
                )
    for node, port, (name,) in _named(tree, Meaning.NEED):
        if name not in needs:
            raise node.error(
                f"port {port}: there is no need {name!r}; add it to the"
                f" person's needs{did_you_mean(name, needs)}"
            )
    for meaning in (Meaning.PERSON, Meaning.PEOPLE):
        for node, port, numbers in _named(tree, meaning):
            _check_people(node, port, numbers, ids)
            if len(numbers) > MAX_PARTNERS or len(set(numbers)) < len(numbers):
                raise node.error(
                    f"port {port}: must be at most {MAX_PARTNERS} different"
                    f" numbers, got {len(numbers)}"
                )
            mine = [it for it in own if it in numbers]
            if meaning is Meaning.PEOPLE and mine:
                raise node.error(
                    f"port {port}: must be numbers of others, got {mine[0]},"
                    " the person's own"
                )


def spoken_texts(tree: _HasNodes) -> dict[float, str]:
    """Returns the texts that a tree may say, by their `text_code`.

    These are all constants of its social leaves that are no names.
    """
    return {
        text_code(value.value): value.value
        for node in tree.nodes
        if node.type.is_social
        for name, value in node.ports.items()
        if isinstance(value, Constant)
        and _is_free_text(node.type.ports[name])
        and value.value
    }


def _is_free_text(port: Port) -> bool:
    return port.base is str and not port.choices and port.meaning is None


def _check_people(
    node: Node, port: str, numbers: Sequence[int], ids: Container[int]
) -> None:
    for number in numbers:
        if number not in ids:
            raise node.error(
                f"port {port}: nobody has the number {number}; give one of a"
                " person's `id`, by default 1, 2, ... in order"
            )


def _named(
    tree: _HasNodes, meaning: Meaning
) -> Iterator[tuple[Node, str, tuple[Any, ...]]]:
    """Yields the constants of ports that name something, with their nodes.

    A default names nobody, and nor does an empty text at or under a node with
    conditions, which may skip it.
    """
    skipped: set[int] = set()
    for node in tree.nodes:
        if node.conditions is not None or id(node) in skipped:
            skipped |= {id(node), *map(id, node.children)}
        for name, value in node.ports.items():
            port = node.type.ports[name]
            if port.meaning is not meaning or not isinstance(value, Constant):
                continue
            given = value.value
            if given == port.default or (given == "" and id(node) in skipped):
                continue
            several = meaning is Meaning.PEOPLE
            yield node, name, people_of(given) if several else (given,)
