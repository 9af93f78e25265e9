"""All cases of the validation, by topic."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from hunav_drake.validation import (
    bends,
    counterflow,
    diagrams,
    doors,
    encounters,
    groups,
    single_people,
)
from hunav_drake.validation.case import Case

TOPICS: Mapping[str, tuple[Case, ...]] = MappingProxyType(
    {
        "Single people": single_people.CASES,
        "Bends, rooms and ways": bends.CASES,
        "Density and speed": diagrams.CASES,
        "Doors": doors.CASES,
        "Counterflow and lanes": counterflow.CASES,
        "Encounters": encounters.CASES,
        "Groups and mixed crowds": groups.CASES,
    }
)

# The cases by name, in the order of the tables.
CASES: Mapping[str, Case] = MappingProxyType(
    {case.name: case for cases in TOPICS.values() for case in cases}
)


def by_topic(names: Iterable[str]) -> dict[str, list[Case]]:
    """Returns the named cases by topic, in order."""
    chosen = set(names)
    found = {
        topic: [case for case in cases if case.name in chosen]
        for topic, cases in TOPICS.items()
    }
    return {topic: cases for topic, cases in found.items() if cases}
