"""The robots of a scenario: one, or several."""

from collections.abc import Callable, Iterable, Iterator
import dataclasses as dc
import math
from typing import NamedTuple

from hunav_drake.scenario.error import Finding, Loc, shown
from hunav_drake.scenario.schema import FleetMember, Scenario
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.sensing.sensor_config import name_sensors

# The parts of a scenario that each of several robots has for itself.
_OWN = ("robot", "planner", "sensors")

# Overlaps up to this are by rounding, in meters.
_SAME = 1e-9


class RobotPart(NamedTuple):
    """A robot of a scenario.

    Attributes:
        name: The name of one of several robots; empty for a single one.
        scenario: The scenario with this robot alone. Of several robots, it
            has the robot's own sensors only.
    """

    name: str
    scenario: Scenario

    @property
    def prefix(self) -> str:
        """The prefix of the names of its systems and ports."""
        return f"{self.name}_" if self.name else ""


def robot_parts(scenario: Scenario) -> list[RobotPart]:
    """Returns the robots of a scenario, in order.

    A list of one robot is the same as the short form, without a name.
    """
    if not scenario.robots:
        return [RobotPart("", scenario)]
    return [
        RobotPart(
            member.name if len(scenario.robots) > 1 else "",
            dc.replace(
                scenario,
                robots=[],
                robot=member.robot,
                planner=member.planner,
                sensors=member.sensors
                if len(scenario.robots) > 1
                else [*member.sensors, *scenario.sensors],
            ),
        )
        for member in scenario.robots
    ]


def robots_of(scenario: Scenario) -> dict[str, RobotConfig]:
    """Returns the robots by their names; that of a single one is empty."""
    return {it.name: it.scenario.robot for it in robot_parts(scenario)}


def planners_of(scenario: Scenario) -> str:
    """Returns the types of planners, each once, as "dwb" or "dwb+sfw"."""
    types = [name_of(it.scenario.planner) for it in robot_parts(scenario)]
    return "+".join(dict.fromkeys(types))


def with_parts(scenario: Scenario, parts: Iterable[RobotPart]) -> Scenario:
    """Returns a scenario with changed robots: see `robot_parts`."""
    if len(scenario.robots) < 2:
        (part,) = parts
        return part.scenario
    robots = [
        FleetMember(
            name=member.name,
            robot=alone.robot,
            planner=alone.planner,
            sensors=alone.sensors,
        )
        for member, (_, alone) in zip(scenario.robots, parts, strict=True)
    ]
    return dc.replace(scenario, robots=robots)


def find_of_each(
    check: Callable[[Scenario], Iterable[Finding]], scenario: Scenario
) -> Iterator[Finding]:
    """Yields what a check finds for each robot, at its place."""
    if not scenario.robots:
        yield from check(scenario)
        return
    told = set()
    for i, part in enumerate(robot_parts(scenario)):
        for found in check(part.scenario):
            moved = dc.replace(
                found,
                loc=_place(scenario, i, found.loc),
                uses=tuple(_place(scenario, i, loc) for loc in found.uses),
            )
            # (Of people and the world, each finds the same.)
            if (moved.loc, moved.message) not in told:
                told.add((moved.loc, moved.message))
                yield moved
    if scenario.sensors and len(scenario.robots) > 1:
        for found in check(dc.replace(scenario, robots=[])):
            if found.loc[:1] == ("sensors",):
                yield found


def _place(scenario: Scenario, i: int, loc: Loc) -> Loc:
    if not loc or loc[0] not in _OWN:
        return loc
    if loc[0] == "sensors" and len(loc) > 1:
        # Those of a list of one robot come before those of the scenario.
        own = len(scenario.robots[i].sensors)
        if int(loc[1]) >= own:
            return ("sensors", int(loc[1]) - own, *loc[2:])
    return ("robots", i, *loc)


# The systems of each robot, and those of a trial: see `MakeTrialDiagram`.
_SYSTEMS = (
    *("robot", "contacts", "planner", "monitor", "goal"),
    *("evaluator", "encounters"),
    *("perception", "perception_delay", "localization", "command_delay"),
    *("other_robot_states", "seen"),
)
_SHARED = (
    *("humans", "plant", "scene", "scene_graph", "robot_states", "touches"),
    *("bodies", "monitor", "statuses", "planner_statuses"),
)


def _check_systems(scenario: Scenario) -> Iterator[Finding]:
    """Finds robots whose systems would have the names of others."""
    taken = {*_SHARED}
    taken |= {f"sensor_{name}" for name in name_sensors(scenario.sensors)}
    for i, member in enumerate(scenario.robots):
        own = {f"{member.name}_{name}" for name in _SYSTEMS}
        sensors = name_sensors(member.sensors)
        own |= {f"{member.name}_sensor_{name}" for name in sensors}
        if clash := min(own & taken, default=""):
            yield Finding(
                ("robots", i, "name"),
                f"makes a second system called {shown(clash)} in the trial;"
                " change it, or the name of a sensor",
            )
        taken |= own


def check_fleet(scenario: Scenario) -> Iterator[Finding]:
    """Checks that several robots have separate names and starts."""
    if not scenario.robots:
        return
    for key in ("robot", "planner"):
        if getattr(scenario, key) != getattr(Scenario(), key):
            yield Finding(
                (key,),
                "must not be given besides robots, each of which has its own;"
                f" move it to robots[0].{key}, or leave robots out",
                uses=(("robots",),),
            )
    for i, sensor in enumerate(scenario.sensors):
        if getattr(sensor, "mount", "robot") == "robot":
            yield Finding(
                ("sensors", i),
                "is on a robot, but the robots are a list; move it to the"
                " sensors of one of them, or give it mount: world",
                uses=(("robots",),),
            )
    unique = {member.name for member in scenario.robots}
    if 1 < len(unique) == len(scenario.robots):
        yield from _check_systems(scenario)
    names: dict[str, int] = {}
    people = {human.name for human in scenario.humans}
    for i, member in enumerate(scenario.robots):
        first = names.setdefault(member.name, i)
        if first != i:
            yield Finding(
                ("robots", i, "name"),
                f"must be unique, but {shown(member.name)} is already the name"
                f" of robots[{first}]; change one",
                uses=(("robots", first, "name"),),
            )
        elif member.name in people:
            yield Finding(
                ("robots", i, "name"),
                f"must be unique, but {shown(member.name)} is the name of a"
                " person; change one",
                uses=(("humans",),),
            )
        for k, other in enumerate(scenario.robots[:i]):
            gap = math.dist(member.robot.start[:2], other.robot.start[:2])
            overlap = member.robot.radius + other.robot.radius - gap
            if overlap > _SAME:
                yield Finding(
                    ("robots", i, "robot", "start"),
                    f"overlaps {shown(other.name)} (robots[{k}]) by"
                    f" {math.ceil(overlap * 100) / 100:.2f} m; move one of"
                    " them",
                    uses=(("robots", k, "robot", "start"),),
                )
