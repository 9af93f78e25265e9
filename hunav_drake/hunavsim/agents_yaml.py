"""Reads HuNavSim's own files: agents.yaml and metrics.yaml.

Both are parameter files of ROS 2 nodes. What they say about people becomes
HumanConfigs, what they say about metrics an EvaluatorConfig. Settings that
mean nothing here (the map, the skins, the heights) are left out.
"""

from collections.abc import Mapping, Sequence
import dataclasses as dc
from pathlib import Path
from types import MappingProxyType
from typing import Any

from hunav_drake.scenario.checks import OWN_CHECKS
from hunav_drake.scenario.error import (
    Fault,
    Loc,
    ScenarioError,
    path_text,
    shown,
    suggestion,
)
from hunav_drake.scenario.schema import Scenario, SimulationConfig
from hunav_drake.scenario.validation import (
    Check,
    Places,
    build_scenario,
    document_faults,
)
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import read_yaml
from hunav_drake.systems.common.suggest import nearest

AGENTS_KEY = "hunav_loader"
_METRICS_KEY = "hunav_evaluator_node"
_PARAMETERS = "ros__parameters"

# The behaviors by their numbers in HuNavSim.
BEHAVIOR_NAMES = {
    1: "regular",
    2: "impassive",
    3: "surprised",
    4: "scared",
    5: "curious",
    6: "threatening",
}

# What an agent's settings are called here.
_HUMAN_FIELDS = {
    "id": "id",
    "group_id": "group_id",
    "max_vel": "desired_speed",
    "radius": "radius",
    "goal_radius": "goal_radius",
    "cyclic_goals": "cyclic",
}
_AGENT_KEYS = (*_HUMAN_FIELDS, "behavior", "init_pose", "goals", "skin")

# The factors of a behavior, given since HuNavSim 2.0, and those of a force.
_FORCE_FIELDS = {
    "goal_force_factor": "goal_factor",
    "obstacle_force_factor": "obstacle_factor",
    "social_force_factor": "social_factor",
}

# The modes of these factors by their numbers in HuNavSim 2.0.
_FORCES_MODES = {
    0: "default",
    1: "custom",
    2: "random_normal",
    3: "random_uniform",
}

# A file with more faults than this is not looked through to its end.
_MAX_FAULTS = 100

_NONE: Mapping[Loc, str] = MappingProxyType({})


def ImportAgents(
    filename: str | Path, *, metrics_filename: str | Path | None = None
) -> Scenario:
    """Reads the people of HuNavSim's agents.yaml as a scenario.

    `max_vel` becomes the desired speed, and the behaviors become those of the
    same names. Whether they are available is not asked here: a scenario is
    checked for that when it is loaded or run. Of HuNavSim 2.0's settings of a
    behavior, the configuration becomes the `forces_mode`, and the factors of
    the forces are taken if that is custom (1); the others belong to reactions
    and are left out.

    The file says nothing about walls and the robot. The world of the result is
    empty, and the robot, of the default kind, stands at (0, 0, 0) without a
    goal.

    Args:
        filename: The agents.yaml.
        metrics_filename: A metrics.yaml, whose frequency and chosen metrics
            become the evaluator's; by default the evaluator is the default
            one. A frequency of 0 means every step.

    Raises:
        ScenarioError: If a file cannot be read, or does not have that form.
            Each fault has its file, line and path.
    """
    imported = convert_agents(read_yaml(filename))
    if metrics_filename is not None:
        imported.add_metrics(read_yaml(metrics_filename))
    return imported.build(OWN_CHECKS)


def convert_agents(document: YamlDocument) -> "HunavImport":
    """Converts an agents.yaml to the data of a scenario.

    Raises:
        ScenarioError: If the list of agents itself cannot be read.
    """
    result = HunavImport(document)
    result.add_agents()
    return result


class HunavImport:
    """The plain data of a scenario, and where HuNavSim's files say them.

    Attributes:
        name: The name of the agents' file.
        data: The scenario so far.
        places: Where its parts come from.
    """

    def __init__(self, document: YamlDocument) -> None:
        """Starts with an empty scenario of the agents' document."""
        self.name = document.name
        self.data: dict[str, Any] = {
            "description": f"Imported from {Path(document.name).name}.",
            "humans": [],
        }
        self._origins: dict[Loc, tuple[YamlDocument, Loc]] = {}
        self.places = Places(document, origins=self._origins)
        self._document = document
        self._known: list[Loc] = []
        self._faults = document_faults(document)

    def build(
        self, checks: Sequence[Check], overrides: Mapping[Loc, str] = _NONE
    ) -> Scenario:
        """Makes the scenario, which must pass checks beyond the schema.

        What was set on the command line is in `overrides`.

        Raises:
            ScenarioError: With all that is wrong in the files.
        """
        scenario, findings = build_scenario(self.data, checks, self._known)
        places = dc.replace(self.places, overrides=overrides)
        faults = list(self._faults)
        faults += [places.fault(found, self.data) for found in findings]
        if scenario is None or faults:
            raise ScenarioError(self.name, faults)
        return scenario

    def add_agents(self) -> None:
        """Adds the listed agents as people."""
        agents = self._parameters(self._document, AGENTS_KEY)
        loc: Loc = (AGENTS_KEY, _PARAMETERS)
        names = agents.get("agents")
        if not isinstance(names, list):
            self._report((*loc, "agents"), "must be a list of agents' names")
            raise ScenarioError(self.name, self._faults)
        described = [key for key, it in agents.items() if isinstance(it, dict)]
        seen = set()
        for i, name in enumerate(names):
            if len(self._faults) > _MAX_FAULTS:
                break
            if not isinstance(name, str):
                problem = f"must be a name, got {shown(name)}"
            elif name in seen:
                problem = f"{shown(name)} is listed twice"
            elif not isinstance(agents.get(name), dict):
                hint = suggestion(name, described[:100])
                problem = f"{shown(name)} is not described; {hint}"
            else:
                seen.add(name)
                self._add_agent(agents[name], name, (*loc, name))
                continue
            self._report((*loc, "agents", i), problem)

    def add_metrics(self, document: YamlDocument) -> None:
        """Adds the evaluator of a metrics.yaml."""
        self._document = document
        self._faults += document_faults(document)
        settings = self._parameters(document, _METRICS_KEY)
        loc: Loc = (_METRICS_KEY, _PARAMETERS)
        evaluator = self.data["evaluator"] = {}
        frequency = settings.get("frequency", 1.0)
        if type(frequency) not in (int, float) or not frequency >= 0:
            rule = "must be a number of Hz, 0 for every step"
            self._report((*loc, "frequency"), f"{rule}, got {shown(frequency)}")
        elif frequency > 0:
            evaluator["period"] = 1.0 / frequency
        else:
            evaluator["period"] = SimulationConfig().time_step
        self._origin(("evaluator", "period"), (*loc, "frequency"))
        chosen = settings.get("metrics", {})
        if not isinstance(chosen, dict):
            rule = "must be a mapping from names to true or false"
            self._report((*loc, "metrics"), f"{rule}, got {shown(chosen)}")
            return
        names = evaluator["metrics"] = []
        self._origin(("evaluator", "metrics"), (*loc, "metrics"))
        for name, wanted in chosen.items():
            here = (*loc, "metrics", name)
            if not isinstance(wanted, bool):
                rule = "must be true or false"
                self._report(here, f"{rule}, got {shown(wanted)}")
            elif wanted:
                self._origin(("evaluator", "metrics", len(names)), here)
                names.append(name)

    def _add_agent(self, agent: dict[str, Any], name: str, loc: Loc) -> None:
        humans = self.data["humans"]
        human: dict[str, Any] = {"name": name}
        here: Loc = ("humans", len(humans))
        humans.append(human)
        self._origin(here, loc)
        for key, field in _HUMAN_FIELDS.items():
            self._origin((*here, field), (*loc, key))
            if key in agent:
                human[field] = agent[key]
        self._look_for_typing_errors(agent, loc)
        self._add_behavior(agent, human, loc, here)
        pose = self._numbers(agent, "init_pose", "xyh", loc, (*here, "pose"))
        if pose is None:
            self._known.append((*here, "pose"))
        else:
            human["pose"] = pose
        self._add_goals(agent, human, loc, here)

    def _add_behavior(
        self, agent: dict[str, Any], human: dict[str, Any], loc: Loc, here: Loc
    ) -> None:
        number = agent.get("behavior", 1)
        loc = (*loc, "behavior")
        if isinstance(number, dict):
            given = number.get("configuration", 0)
            mode = self._choice(given, _FORCES_MODES, (*loc, "configuration"))
            human["forces_mode"] = mode or "default"
            if mode == "custom":
                forces = human["forces"] = {}
                for key, field in _FORCE_FIELDS.items():
                    self._origin((*here, "forces", field), (*loc, key))
                    if key in number:
                        forces[field] = number[key]
            number = number.get("type", 1)
            loc = (*loc, "type")
        self._origin((*here, "behavior"), loc)
        if behavior := self._choice(number, BEHAVIOR_NAMES, loc):
            human["behavior"] = behavior

    def _choice(
        self, number: Any, names: Mapping[int, str], loc: Loc
    ) -> str | None:
        """Returns the name of a number; reports one that is not known."""
        if type(number) is int and number in names:
            return names[number]
        known = ", ".join(f"{k} {v}" for k, v in names.items())
        self._report(loc, f"must be one of {known}; got {shown(number)}")
        return None

    def _add_goals(
        self, agent: dict[str, Any], human: dict[str, Any], loc: Loc, here: Loc
    ) -> None:
        names = agent.get("goals", [])
        self._origin((*here, "goals"), (*loc, "goals"))
        if not isinstance(names, list):
            rule = "must be a list of goals' names"
            self._report((*loc, "goals"), f"{rule}, got {shown(names)}")
            return
        goals = human["goals"] = []
        for i, name in enumerate(names):
            if len(self._faults) > _MAX_FAULTS:
                break
            if not isinstance(name, str) or name not in agent:
                problem = f"there is no goal {shown(name)}"
                self._report((*loc, "goals", i), problem)
                continue
            at: Loc = (*here, "goals", len(goals))
            goal = self._numbers(agent, name, "xy", loc, at)
            if goal is not None:
                goals.append(goal)

    def _numbers(
        self, agent: dict[str, Any], name: str, keys: str, loc: Loc, here: Loc
    ) -> list[Any] | None:
        """Returns x, y and perhaps h of a point; reports what is missing."""
        loc = (*loc, name)
        self._origin(here, loc)
        point = agent.get(name)
        if not isinstance(point, dict):
            rule = "must be a mapping with x and y"
            self._report(loc, f"{rule}, got {shown(point)}")
            return None
        missing = [key for key in "xy" if key not in point]
        for key in missing:
            self._report((*loc, key), "is missing")
        for i, key in enumerate(keys):
            self._origin((*here, i), (*loc, key))
        return None if missing else [point.get(key, 0.0) for key in keys]

    def _look_for_typing_errors(self, agent: dict[str, Any], loc: Loc) -> None:
        """Reports a key that looks like a known one; others are let be."""
        for key in agent:
            if key in _AGENT_KEYS or len(key) > 20:
                continue
            near = nearest(key, _AGENT_KEYS, 0.8)
            if near and near not in agent:
                problem = f"unknown key; did you mean {shown(near)}?"
                self._report((*loc, key), problem)

    def _parameters(self, document: YamlDocument, node: str) -> dict[str, Any]:
        """Returns the parameters of a ROS 2 node."""
        if document.root is not None:
            parameters = document.plain((node, _PARAMETERS))
            if isinstance(parameters, dict):
                return parameters
            found = document.plain()
            keys = list(found)[:10] if isinstance(found, dict) else []
            has = ", ".join(map(shown, keys)) or "no keys"
            message = f"is missing; the file has {has}"
            path = f"{node}.{_PARAMETERS}"
            self._faults.append(Fault(document.name, 0, path, message))
        raise ScenarioError(document.name, self._faults)

    def _origin(self, here: Loc, loc: Loc) -> None:
        self._origins[here] = (self._document, loc)

    def _report(self, loc: Loc, message: str) -> None:
        name, line = self._document.name, self._document.line(loc)
        path = path_text(None, loc[2:])
        self._faults.append(Fault(name, line, path, message))
