"""Names and numbers of people."""

from collections.abc import Sequence
import dataclasses
import itertools

from hunav_drake.systems.people.human_config import HumanConfig


def people_ids(humans: Sequence[HumanConfig]) -> list[int]:
    """Returns the numbers of people, by which other programs know them.

    People without a number get 1, 2, ... in order, except those that are taken.
    """
    taken = {human.id for human in humans}
    free = (k for k in itertools.count(1) if k not in taken)
    return [next(free) if human.id is None else human.id for human in humans]


def people_names(humans: Sequence[HumanConfig]) -> list[str]:
    """Returns the names of people.

    People without a name get "human_1", "human_2", ... in order, except those
    that are taken.
    """
    taken = {human.name for human in humans}
    free = (
        name for k in itertools.count(1) if (name := f"human_{k}") not in taken
    )
    return [human.name or next(free) for human in humans]


def name_people(humans: Sequence[HumanConfig]) -> list[HumanConfig]:
    """Returns people with the names of `people_names` and their `people_ids`.

    The arguments are not changed.
    """
    return [
        dataclasses.replace(human, name=name, id=number)
        for human, name, number in zip(
            humans, people_names(humans), people_ids(humans), strict=True
        )
    ]


def check_consistent(humans: Sequence[HumanConfig]) -> None:
    """Checks that names and numbers are unique, and speeds consistent.

    Raises:
        ValueError: If two people have the same name or number, or if a
            `max_speed` is below the `desired_speed`.
    """
    taken: dict[tuple[str, object], int] = {}
    for i, human in enumerate(humans):
        for key in ("name", "id"):
            value = getattr(human, key)
            if value in ("", None):
                continue
            first = taken.setdefault((key, value), i)
            if first != i:
                what = "name" if key == "name" else "number"
                raise ValueError(
                    f"two people have the {what} {value!r}: humans[{first}] and"
                    f" humans[{i}]; leave {key} out to have it given"
                )
        if human.speed_limit < human.desired_speed:
            raise ValueError(
                f"humans[{i}].max_speed must be at least the desired_speed,"
                f" {human.desired_speed:g} m/s, got {human.max_speed:g} m/s"
            )
