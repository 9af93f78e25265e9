"""What can be chosen in a trial, taken from the schema and the registers.

A factor is one choice, known by its path in a scenario, with its levels as
texts; a row has a level for each factor. What a choice has of choices of its
own, as the kernel of a motion model, is a factor that only applies with it.
"""

import dataclasses
from functools import cache
from itertools import product
import json
from pathlib import Path
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

from hunav_drake import ListScenarios, LoadScenario, Scenario
from hunav_drake.runs.result_files import Format
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    SourceConfig,
)
from hunav_drake.systems.planning import PERCEPTIONS
from hunav_drake.systems.robot import ROBOTS
from hunav_drake.systems.scene.scene_config import OVERLAYS
from hunav_drake.systems.sensing import SENSORS
from hunav_drake.systems.world.obstacles import inside
from hunav_drake.views.camera import VIEWS
from tests.choices import NEEDED, shipped

# The level at which a scenario stays as it is.
GIVEN = "given"

# What is large by default, and made smaller to take less time.
SMALLER = {
    ("planner", "mppi"): "planner.batch_size=60",
    ("sensors", "camera"): "sensors[0].image_size=[80, 60]",
}

# A file of recorded people.
_RECORDED = Path(__file__).parents[1] / "data" / "recorded_corridor.csv"

Row = dict[str, str]


class Factor(NamedTuple):
    """One choice.

    Attributes:
        levels: What can be chosen.
        owners: The levels of other factors with which it applies, each as
            (factor, level); with none, it always does.
        tag: The key that names a choice of a register.
    """

    levels: tuple[str, ...]
    owners: frozenset[tuple[str, str]] = frozenset()
    tag: str = ""


class Refusal(NamedTuple):
    """What is refused by rule.

    Attributes:
        when: The levels by factor that do not go together.
        words: What the message says.
    """

    when: dict[str, frozenset[str]]
    words: str


@cache
def factors() -> dict[str, Factor]:
    """Returns all factors by their paths, owners before what they own."""
    found: dict[str, Factor] = {
        "scenario": Factor(tuple(ListScenarios())),
        "humans.behavior": Factor(tuple(sorted(BEHAVIORS))),
        "population": Factor((GIVEN, "cohorts", "sources", "tracks")),
        "sensors": Factor(("none", *sorted(SENSORS))),
        "simulation.time_step": Factor(("0.1", "0.05", "0.01")),
        "simulation.start_jitter": Factor(("0.0", "0.2")),
        "robot.goal": Factor((GIVEN, "null")),
        "robot.command_delay": Factor(("0.0", "0.1")),
        "scene.overlays": Factor((GIVEN, "[]", json.dumps(OVERLAYS))),
        "view": Factor(("none", "replay", *VIEWS)),
        "format": Factor(get_args(Format)),
    }
    _walk(found, Scenario, "", None)
    _walk(found, HumanConfig, "humans.", None)
    for kind, cls in (("cohorts", CohortConfig), ("sources", SourceConfig)):
        _walk(found, cls, f"population.{kind}[0].", ("population", kind))
    for kind in shipped(SENSORS):
        _walk(found, SENSORS[kind], "sensors[0].", ("sensors", kind))
    found |= {
        "planner.sees.delay": Factor(
            ("0.0", "0.2"), frozenset({("planner.sees", "detector")})
        ),
        "sensors[0].dropout": Factor(
            ("0.0", "0.1"), frozenset({("sensors", "lidar")})
        ),
        "sensors[0].delay": Factor(
            ("0.0", "0.1"),
            frozenset(
                ("sensors", it)
                for it in ("lidar", "visible_people", "people_detector")
            ),
        ),
    }
    # (Others drive the robot in tests of their own.)
    found["planner.lockstep"] = found["planner.lockstep"]._replace(
        levels=("false",)
    )
    return found


def _walk(
    found: dict[str, Factor],
    cls: type[Any],
    prefix: str,
    owner: tuple[str, str] | None,
) -> None:
    """Adds the choices among the fields of a dataclass, and below."""
    for name, hint in get_type_hints(cls, include_extras=True).items():
        path = prefix + name
        registry = next(
            (it for it in get_args(hint) if isinstance(it, Registry)), None
        )
        if registry is not None:
            _add(found, path, tuple(shipped(registry)), owner, "type")
            for choice in shipped(registry):
                _walk(found, registry[choice], f"{path}.", (path, choice))
        elif dataclasses.is_dataclass(hint):
            if path not in ("world", "population"):
                _walk(found, hint, f"{path}.", owner)
        elif levels := _levels(hint):
            _add(found, path, levels if owner else (GIVEN, *levels), owner)


def _add(
    found: dict[str, Factor],
    path: str,
    levels: tuple[str, ...],
    owner: tuple[str, str] | None,
    tag: str = "",
) -> None:
    old = found.get(path, Factor(()))
    found[path] = Factor(
        tuple(dict.fromkeys(old.levels + levels)),
        old.owners | ({owner} if owner else frozenset()),
        tag,
    )


def _levels(hint: Any) -> tuple[str, ...]:
    """Returns the values of a flag or of a few words, as YAML; else none."""
    if get_origin(hint) is Annotated:
        return _levels(get_args(hint)[0])
    if get_origin(hint) in (Union, UnionType):
        parts = [_levels(it) for it in get_args(hint) if it is not NoneType]
        return ("null", *sum(parts, ())) if all(parts) else ()
    if hint is bool:
        return ("true", "false")
    if get_origin(hint) is Literal:
        return tuple(map(str, get_args(hint)))
    return ()


def applies(path: str, row: Row) -> bool:
    """Returns whether a factor counts, as far as a row is known."""
    owners = factors()[path].owners
    return path in row and (
        not owners
        or any(row.get(at) == it and applies(at, row) for at, it in owners)
    )


@cache
def refusals() -> list[Refusal]:
    """Returns all that is refused, and how the message tells it."""
    physical = frozenset(it for it in ROBOTS if ROBOTS[it].physical)
    open_places = frozenset(
        it for it in ListScenarios() if _shipped(it).population.sources
    )
    come_and_go = "bodies of a MultibodyPlant cannot come and go"
    return [
        Refusal(
            {"robot": physical, "population": frozenset({"sources", "tracks"})},
            come_and_go,
        ),
        Refusal(
            {
                "robot": physical,
                "population": frozenset({GIVEN}),
                "scenario": open_places,
            },
            come_and_go,
        ),
        *(
            Refusal(
                {
                    path: frozenset({level}),
                    "planner.sees": frozenset(PERCEPTIONS) - {"lidar"},
                    "sensors": frozenset({"none", *SENSORS}) - {"lidar"},
                },
                "needs a lidar (port scan), and there is none",
            )
            for path, level in (
                ("planner.obstacle_layer.source", "lidar"),
                ("planner.scan", "true"),
            )
        ),
        Refusal(
            {
                "evaluator.start": frozenset({"at_goal_command"}),
                "robot.goal": frozenset({"null"}),
            },
            "where the robot has no goal: nothing would be recorded",
        ),
    ]


def refusal(row: Row) -> str:
    """Returns what is said of a row that is refused; else an empty text."""
    for it in refusals():
        if all(applies(p, row) and row[p] in s for p, s in it.when.items()):
            return it.words
    return ""


def refused_parts() -> list[Row]:
    """Returns each least part of a row that is refused."""
    return [
        dict(zip(it.when, levels, strict=True))
        for it in refusals()
        for levels in product(*map(sorted, it.when.values()))
    ]


@cache
def _shipped(name: str) -> Scenario:
    return LoadScenario(filename=name)


@cache
def _seated(name: str) -> frozenset[int]:
    """Returns who starts on a seat: only those who use it on foot may."""
    scenario = _shipped(name)
    places = [it.pose[:2] for it in scenario.humans]
    if not places:
        return frozenset()
    within = inside(scenario.world.obstacles(), np.array(places)).any(axis=1)
    return frozenset(np.flatnonzero(within).tolist())


def overrides(row: Row) -> list[str]:
    """Returns a row as settings of its scenario, as `hunav --set` has them."""
    result = ["simulation.duration=3.0"]
    for path, factor in factors().items():
        level = row[path]
        if path in ("scenario", "view", "format") or not applies(path, row):
            continue
        if level == GIVEN:
            continue
        if path == "population":
            result.append(f"population={_population(row['scenario'], level)}")
        elif path == "sensors":
            data = [] if level == "none" else [{"type": level}]
            result.append(f"sensors={json.dumps(data)}")
        elif path == "robot":
            result.append(f"robot.type={level}")
            result += [
                f"robot.{key}={json.dumps(value)}"
                for key, value in NEEDED.get(level, {}).items()
            ]
        elif path.startswith("humans."):
            key = path.removeprefix("humans.")
            is_kept = key in ("behavior", "figure.wheelchair")
            kept = _seated(row["scenario"]) if is_kept else ()
            result += [
                f"humans[{i}].{key}={level}"
                for i in range(len(_shipped(row["scenario"]).humans))
                if i not in kept
            ]
        elif factor.tag:
            data = {factor.tag: level, **NEEDED.get(level, {})}
            result.append(f"{path}={json.dumps(data)}")
        else:
            result.append(f"{path}={level}")
    result += [
        it for (path, level), it in SMALLER.items() if row[path] == level
    ]
    if row["simulation.time_step"] == "0.1":
        # What is shorter by default must be a multiple.
        result += ["planner.period=0.1", "evaluator.period=0.1"]
    return result


@cache
def _population(scenario: str, kind: str) -> str:
    """Returns people who come, or are, where those of a scenario are.

    Recorded ones walk where they did, also through walls.
    """
    if kind == "tracks":
        return json.dumps({"tracks": {"file": str(_RECORDED)}})
    trial = _shipped(scenario)
    places = [
        *(human.pose[:2] for human in trial.humans),
        *(goal for human in trial.humans for goal in human.goals),
        *(p[:2] for p in (trial.robot.start, trial.robot.goal) if p),
    ]
    xs, ys = zip(*places, strict=True)
    box = [min(xs) - 0.5, min(ys) - 0.5, max(xs) + 0.5, max(ys) + 0.5]
    area = {"rectangle": [round(float(x), 3) for x in box]}
    people = {
        "start": [area],
        "goals": [area],
        "group_sizes": [1, 1],
        "radius": 0.3,
    }
    if kind == "cohorts":
        return json.dumps({"cohorts": [{"number": 3, **people}]})
    source = {"name": "in", "rate": 0.2, "max_present": 16, "sinks": {"out": 1}}
    sinks = [{"name": "out", "area": area}]
    return json.dumps({"sources": [source | people], "sinks": sinks})
