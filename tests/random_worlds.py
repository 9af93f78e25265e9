"""Trials whose world, robot, sensors and people are drawn from the schema.

Whatever is registered is drawn, with its options: numbers between a half and
the double of their defaults, as far as their bounds allow.
"""

from functools import cache
import json
import re
from typing import Any

import numpy as np

from hunav_drake import LoadScenario, Scenario, ScenarioError
from hunav_drake.scenario.json_schema import described_schema
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.population_config import CohortConfig
from hunav_drake.systems.planning import PERCEPTIONS, PLANNERS
from hunav_drake.systems.robot import DRIVES, ROBOTS
from hunav_drake.systems.sensing import LOCALIZATIONS, SENSORS
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import WALLS
from tests.choices import NEEDED, shipped

Data = dict[str, Any]

WIDTH, HEIGHT = 12.0, 9.0
DURATION = 8.0
STEPS = (0.025, 0.05)

# What is not drawn: what is asked of bodies holds with walls that stop them,
# and what makes a trial slow is another matter.
_FIXED = {
    "walls_stop",
    "keep_out_of_walls",
    "keep_apart",
    "period",
    "noise_seed",
    "kernel",
    "image_size",
    "batch_size",
    "time_steps",
    "max_speed",
}

# How far bodies start apart, in meters.
_APART = 0.9

# How often what is faulty is left out, or drawn anew.
_ROUNDS = 60


def draw_world(seed: int) -> Scenario:
    """Returns a trial that can be simulated; what cannot is left out."""
    rng = np.random.default_rng([seed, 11])
    data = _draw(rng, seed)
    for _ in range(_ROUNDS):
        data["humans"] = _apart(data)
        try:
            return LoadScenario(data=json.dumps(data))
        except ScenarioError as error:
            paths = {fault.path for fault in error.faults}
            told = str(error)
        _amend(data, paths, rng, told)
    raise AssertionError(f"seed {seed}: still refused: {told}")


def _amend(
    data: Data, paths: set[str], rng: np.random.Generator, told: str
) -> None:
    """Leaves out the members of lists that are faulty; moves the robot."""
    members = set()
    for path in paths:
        if found := re.match(r"([a-z.]+)\[(\d+)\]", path):
            members.add((found[1], int(found[2])))
        elif path.startswith("robot"):
            data["robot"] |= _ends(rng)
        elif path.startswith("population"):
            data["population"] = {}
        elif path.startswith("planner"):
            data["planner"] = {"type": data["planner"]["type"]}
        else:
            raise AssertionError(told)
    for path, index in sorted(members, reverse=True):
        whole: Any = data
        for key in path.split("."):
            whole = whole[key]
        del whole[index]


def _apart(data: Data) -> list[Data]:
    """Returns who starts apart from the robot and from all before."""
    places = [data["robot"]["start"][:2]]
    found = []
    for human in data["humans"]:
        place = human["pose"][:2]
        if np.hypot(*(np.array(places) - place).T).min() >= _APART:
            places.append(place)
            found.append(human)
    return found


def _draw(rng: np.random.Generator, seed: int) -> Data:
    corners = [[0, 0], [WIDTH, 0], [WIDTH, HEIGHT], [0, HEIGHT], [0, 0]]
    walls = [
        {"type": "polyline", "points": [corners[i], corners[i + 1]]}
        for i in range(4)
    ]
    walls += [_wall(rng) for _ in range(rng.integers(0, 6))]
    furniture = [
        _drawn(rng, FURNITURE) | _somewhere(rng)
        for _ in range(rng.integers(0, 12))
    ]
    behaviors = [*BEHAVIORS]
    humans = [
        _options(rng, HumanConfig)
        | {
            "pose": [*_place(rng), float(rng.uniform(-3, 3))],
            "goals": [_place(rng) for _ in range(rng.integers(0, 3))],
            "behavior": str(rng.choice(behaviors)),
            "group_id": int(rng.choice([-1, -1, 1, 2])),
        }
        for _ in range(rng.integers(0, 40))
    ]
    cohorts = [
        _options(rng, CohortConfig)
        | {
            "number": int(rng.integers(0, 5)),
            "start": [_area(rng)],
            "goals": [_area(rng) for _ in range(rng.integers(0, 3))],
            "behaviors": {str(rng.choice(behaviors)): 1.0},
            "radius": 0.35,
        }
        for _ in range(rng.integers(0, 3))
    ]
    robot = _drawn(rng, ROBOTS) | _ends(rng)
    if ROBOTS[robot["type"]].physical:
        # The disc that is asked for is that of the body.
        robot.pop("radius")
        if robot["type"] == "urdf":
            drive = str(rng.choice([*DRIVES]))
            robot |= {"radius": 0.27}
            robot["drive"] = {"type": drive, **NEEDED.get(drive, {})}
            if drive == "omnidirectional":
                robot["drive"]["height"] = 0.01
    # (Without somebody who drives it, `bridge` is like `external`.)
    planner = _drawn(rng, PLANNERS, without="bridge")
    planner["sees"] = _drawn(rng, PERCEPTIONS)
    planner["localization"] = _drawn(rng, LOCALIZATIONS)
    if (
        "batch_size"
        in described_schema(PLANNERS[planner["type"]])["properties"]
    ):
        planner["batch_size"] = 60
    return {
        "world": {"walls": walls, "furniture": furniture},
        "crowd": {"model": _drawn(rng, MOTION_MODELS)},
        "humans": humans,
        "population": {"seed": seed, "cohorts": cohorts},
        "robot": robot,
        "planner": planner,
        "sensors": [_sensor(rng) for _ in range(rng.integers(0, 4))],
        "evaluator": {"period": 0.1, "metrics": ["duration"]},
        "simulation": {
            "time_step": float(rng.choice(STEPS)),
            "duration": DURATION,
            "seed": seed,
            "stuck_time": 1e3,
        },
    }


def _drawn(
    rng: np.random.Generator, registry: Registry, without: str = ""
) -> Data:
    """Returns a choice of a register, with its options."""
    names = [it for it in shipped(registry) if it != without]
    name = str(rng.choice(names))
    needed = NEEDED.get(name, {})
    return {"type": name, **needed, **_options(rng, registry[name])}


def _wall(rng: np.random.Generator) -> Data:
    wall = _drawn(rng, WALLS) | {"height": float(rng.uniform(0.1, 3.0))}
    if "points" in wall:
        middle = np.array(_place(rng))
        angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 7)))
        ways = np.transpose([np.cos(angles), np.sin(angles)])
        reach = rng.uniform(0.2, 1.2, (len(angles), 1))
        return wall | {"points": (middle + reach * ways).tolist()}
    size = rng.uniform(0.05, 2.5, 2).tolist()
    return wall | _somewhere(rng) | {"size": size}


def _sensor(rng: np.random.Generator) -> Data:
    sensor = _drawn(rng, SENSORS)
    sensor["pose"] = [*rng.uniform(-0.2, 0.2, 2), rng.uniform(-3, 3)]
    if sensor["mount"] == "world":
        sensor["pose"] = [*_place(rng), rng.uniform(-3, 3)]
    if sensor["type"] == "camera":
        sensor["image_size"] = rng.integers(16, 65, 2).tolist()
    return sensor


def _options(rng: np.random.Generator, cls: Any) -> Data:
    """Returns flags, words and numbers of a dataclass."""
    schema = _schema(cls)
    return _of_properties(rng, schema, schema.get("$defs", {}))


@cache
def _schema(cls: Any) -> Data:
    return described_schema(cls)


def _of_properties(rng: np.random.Generator, schema: Data, defs: Data) -> Data:
    result: Data = {}
    for key, part in sorted(schema.get("properties", {}).items()):
        default = part.get("default")
        if key in _FIXED:
            continue
        if "$ref" in part:
            whole = defs[part["$ref"].rsplit("/", 1)[-1]]
            result[key] = _of_properties(rng, whole, defs)
        elif "enum" in part:
            result[key] = str(rng.choice(part["enum"]))
        elif part.get("type") == "boolean":
            result[key] = bool(rng.integers(2))
        elif part.get("type") in ("number", "integer") and default:
            value = default * 2.0 ** rng.uniform(-1, 1)
            low = part.get("minimum", part.get("exclusiveMinimum", value))
            value = min(max(value, low), part.get("maximum", value))
            whole_number = part["type"] == "integer"
            result[key] = round(value) if whole_number else float(value)
    return result


def _somewhere(rng: np.random.Generator) -> Data:
    return {"center": _place(rng), "yaw": float(rng.uniform(-3, 3))}


def _place(rng: np.random.Generator) -> list[float]:
    return rng.uniform([0.6, 0.6], [WIDTH - 0.6, HEIGHT - 0.6]).tolist()


def _ends(rng: np.random.Generator) -> Data:
    """Returns where the robot starts and goes."""
    angles = rng.uniform(-3, 3, 2).tolist()
    return {
        "start": [*_place(rng), angles[0]],
        "goal": [*_place(rng), angles[1]],
    }


def _area(rng: np.random.Generator) -> Data:
    x, y = _place(rng)
    return {"rectangle": [max(x - 2, 0.5), max(y - 2, 0.5), x + 0.4, y + 0.4]}
