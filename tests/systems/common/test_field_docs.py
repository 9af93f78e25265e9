"""Every field of a configuration says what it means, at a prompt too."""

import dataclasses
import importlib
import inspect
from pathlib import Path
import pydoc
import re
from typing import Annotated, get_args, get_origin

from pydantic.dataclasses import dataclass, is_pydantic_dataclass
import pytest

import hunav_drake
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.common.field_docs import class_doc, explain, field_docs
from hunav_drake.systems.common.layout import Command, Contact, Hold, RobotRole
from hunav_drake.systems.common.schema import CONFIG, Speed, Within
from hunav_drake.systems.evaluation.running_metrics import RunningMetric
from hunav_drake.systems.evaluation.trial_monitor import TrialStatus
from hunav_drake.systems.people.population_config import AgeBand
from hunav_drake.systems.planning.planner import PlannerStatus

# The words of units in sentences, besides their signs.
WORDS = {
    "m": "meters",
    "rad": "radians",
    "s": "seconds",
    "N": "newtons",
    "people/s": "people .* per second",
}
ENUMS = [
    *(Command, Contact, Hold, RobotRole, NodeStatus),
    *(RunningMetric, TrialStatus, PlannerStatus),
]


@pytest.fixture(scope="module")
def configurations():
    """All dataclasses of the package that check their fields."""
    found = {}
    root = Path(hunav_drake.__file__).parent
    # A link, in a clone, which the first search does not follow.
    blocks = (root / "systems").rglob("*.py")
    for file in sorted({*root.rglob("*.py"), *blocks}):
        if "config=CONFIG" not in file.read_text():
            continue
        place = file.relative_to(root.parent).with_suffix("")
        module = importlib.import_module(".".join(place.parts))
        for value in vars(module).values():
            if (
                isinstance(value, type)
                and is_pydantic_dataclass(value)
                and value.__module__ == module.__name__
            ):
                found[value.__qualname__] = value
    assert len(found) > 60
    assert found.keys() >= {"HumanConfig", "Scenario", "DwbPlanner", "Suite"}
    return found


def _units(annotation):
    """Yields the units of the numbers that a type holds."""
    if get_origin(annotation) is Annotated:
        for part in annotation.__metadata__:
            if isinstance(part, Within) and part.unit:
                yield part.unit
    for part in get_args(annotation):
        yield from _units(part)


def _fault(text, annotation):
    """Returns what is missing in the words on a field."""
    if not (text[:1].isupper() and text.endswith(".") and len(text) > 8):
        return "is no sentence"
    for unit in set(_units(annotation)):
        said = rf"(^|\W)({re.escape(unit)}|{WORDS.get(unit, '$.')})(\W|$)"
        if not re.search(said, text):
            return f"does not tell the unit {unit}"
    return ""


def test_every_field_says_what_it_means_with_its_unit(configurations):
    faults = [
        f"{name}.{field.name} {fault}: {text!r}"
        for name, cls in configurations.items()
        for field in dataclasses.fields(cls)
        if (
            fault := _fault(
                text := field_docs(cls).get(field.name, ""), field.type
            )
        )
    ]
    assert not faults, "\n".join(faults)


def test_help_begins_with_what_one_can_read(configurations):
    for cls in configurations.values():
        if ".editor." in cls.__module__:
            # Places to start with in the editor, which one makes nowhere else.
            continue
        text = pydoc.plain(pydoc.render_doc(cls))
        head = re.split(r"\|  (?:Method|-----|Data )", text)[0]
        assert class_doc(cls).splitlines()[0] in head
        for alien in ("Annotated", "Strict", "FieldInfo", "pydantic"):
            assert alien not in head
        for field in dataclasses.fields(cls):
            assert f"|      {field.name}: " in head
            # So it is in notebooks, which ask otherwise.
            assert f"    {field.name}: " in inspect.getdoc(cls)


@pytest.mark.parametrize("enum", ENUMS, ids=lambda it: it.__name__)
def test_every_member_of_an_enum_says_what_it_means(enum):
    head = pydoc.plain(pydoc.render_doc(enum)).split("|  Method")[0]
    for name, member in enum.__members__.items():
        assert member.__doc__.endswith("."), name
        assert f"|      {name}: " in head


def test_help_of_a_configuration():
    text = pydoc.plain(pydoc.render_doc(AgeBand))
    assert text.splitlines()[2:10] == [
        "class AgeBand(builtins.object)",
        " |  AgeBand(*, low: float, high: float, weight: float = 1.0)",
        " |",
        " |  A share of people with uniformly distributed ages.",
        " |",
        " |  Attributes:",
        " |      low: Lowest age of the band, in years.",
        " |      high: Highest age of the band, in years.",
    ]


def test_a_derived_class_has_the_words_of_its_base():
    @explain
    @dataclass(kw_only=True, config=CONFIG)
    class Base:
        """Walks."""

        speed: Speed = 1.0
        """How fast it walks,
        in m/s."""

        # Not told.
        other: int | None = None

    @explain
    @dataclass(kw_only=True, config=CONFIG)
    class Derived(Base):
        speed: Speed = 2.0

    assert field_docs(Derived) == {"speed": "How fast it walks, in m/s."}
    assert Base.__doc__.splitlines()[0] == "Walks."
    assert Derived.__doc__.split() == (
        ["Attributes:", "speed:", "How", "fast", "it", "walks,", "in", "m/s."]
    )


def test_a_class_without_source_has_no_words():
    made = {"explain": explain, "dataclass": dataclass, "__name__": "nowhere"}
    exec(
        "@explain\n@dataclass\nclass A:\n    'A.'\n    x: int = 0\n    'An x.'",
        made,
    )
    assert made["A"].__doc__ == "A."
    assert field_docs(made["A"]) == {}
