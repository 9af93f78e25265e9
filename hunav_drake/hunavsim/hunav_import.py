"""Converts HuNavSim's files to the plain data of a scenario."""

from collections.abc import Mapping, Sequence
import contextlib
import dataclasses as dc
import os
from pathlib import Path
import sys
from types import MappingProxyType
from typing import Any
from xml.etree.ElementTree import ParseError

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import parse

from hunav_drake.hunavsim.agents_keys import (
    AGENT_KEYS,
    BEHAVIOR_NAMES,
    DEFAULTS,
    FORCE_FIELDS,
    FORCES_MODES,
    HUMAN_FIELDS,
    METRICS_KEYS,
    METRICS_LEFT_OUT,
    left_out_of_agent,
    steps_for,
)
from hunav_drake.hunavsim.import_notes import LeftOut
from hunav_drake.hunavsim.reactions import reaction_ports
from hunav_drake.scenario.building import (
    Check,
    Places,
    build_scenario,
    document_faults,
)
from hunav_drake.scenario.error import (
    Fault,
    Loc,
    ScenarioError,
    path_text,
    shown,
    suggestion,
)
from hunav_drake.scenario.schema import Scenario, SimulationConfig
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.systems.common.files import as_file_name
from hunav_drake.systems.common.suggest import nearest
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.planning.planner import PLANNERS
from hunav_drake.systems.world.shapes import World
from hunav_drake.systems.world.solids import WorldFileError

AGENTS_KEY = "hunav_loader"
_METRICS_KEY = "hunav_evaluator_node"
_GOALS = "global_goals"
_NUMBERS = {name: number for number, name in BEHAVIOR_NAMES.items()}
_AGENTS_KEYS = ("agents", "map", "yaml_base_name", _GOALS)
_PARAMETERS = "ros__parameters"

# The limits of reported faults and of reported ignored settings.
_MAX_FAULTS = 100
_MAX_LEFT_OUT = 1000

# The defaults of people here.
_USUAL = HumanConfig(pose=(0.0, 0.0, 0.0))

_NONE: Mapping[Loc, str] = MappingProxyType({})


class HunavImport:
    """The plain data of a scenario, and their places in HuNavSim's files.

    Attributes:
        name: The name of the agents' file.
        data: The scenario so far.
        places: The places of its parts.
        left_out: The settings that were not imported, or assumed.
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
        self.left_out: list[LeftOut] = []
        # Points by their numbers, which agents share.
        self._goals: dict[int, list[Any]] = {}

    def build(
        self, checks: Sequence[Check], overrides: Mapping[Loc, str] = _NONE
    ) -> Scenario:
        """Builds the scenario.

        Args:
            checks: The checks beyond the schema.
            overrides: The text of the override of each overridden part.

        Raises:
            ScenarioError: With all faults of the files.
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
        for key, value in agents.items():
            if not isinstance(value, dict) and key not in _AGENTS_KEYS:
                self._leave_out((*loc, key), "has no meaning here")
        self._add_places(agents.pop(_GOALS, {}), (*loc, _GOALS))
        base = agents.get("yaml_base_name")
        stem = base if isinstance(base, str) else Path(self.name).stem
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
                tree = self._tree(stem, agents[name].get("id", i + 1))
                self._add_agent(agents[name], name, (*loc, name), tree)
                continue
            self._report((*loc, "agents", i), problem)

    def add_map(self, folder: Path, filename: str | Path | None) -> None:
        """Adds a map: a given YAML file, or that of the agents' file.

        The latter must be in `folder`, or in `maps` in or beside it.
        """
        loc: Loc = (AGENTS_KEY, _PARAMETERS, "map")
        if filename is None:
            name = self._document.plain(loc)
            if not isinstance(name, str):
                return
            file = f"{name.removesuffix('.yaml')}.yaml"
            found = _beside(folder, "maps", file)
            if found is None:
                self._leave_out(
                    loc, f"there is no {file} beside; give it by --map"
                )
                return
            filename = found
        try:
            World(map=os.path.abspath(filename)).fixtures()
        except WorldFileError as error:
            self._report(loc, str(error))
            return
        self.data["world"] = {"map": os.path.abspath(filename)}

    def add_metrics(self, document: YamlDocument) -> None:
        """Adds the evaluator of a metrics.yaml."""
        self._document = document
        self._faults += document_faults(document)
        settings = self._parameters(document, _METRICS_KEY)
        loc: Loc = (_METRICS_KEY, _PARAMETERS)
        evaluator = self.data["evaluator"] = {}
        frequency = settings.get("frequency", 1.0)
        if type(frequency) not in (int, float) or not (
            0 <= frequency <= sys.float_info.max
        ):
            rule = "must be a number of Hz, 0 for every step"
            self._report((*loc, "frequency"), f"{rule}, got {shown(frequency)}")
        else:
            usual = SimulationConfig().time_step
            period = 1.0 / frequency if frequency > 0 else usual
            evaluator["period"] = period
            self._set_time_step(period, usual, (*loc, "frequency"))
        self._origin(("evaluator", "period"), (*loc, "frequency"))
        tag = settings.get("experiment_tag")
        if isinstance(tag, str | int | float):
            stem = Path(self.name).stem[:40]
            self.data["name"] = as_file_name(f"{stem}_{tag}")
            self._origin(("name",), (*loc, "experiment_tag"))
        for key in settings:
            if key not in METRICS_KEYS:
                self._leave_out((*loc, key), "has no meaning here")
            elif key in METRICS_LEFT_OUT:
                self._leave_out((*loc, key), METRICS_LEFT_OUT[key])
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

    def _add_places(self, goals: Any, loc: Loc) -> None:
        """Adds the numbered goals of HuNavSim 2, which agents share."""
        if not isinstance(goals, dict):
            rule = "must be a mapping from numbers to points"
            self._report(loc, f"{rule}, got {shown(goals)}")
            return
        places = self.data["places"] = []
        for number, point in goals.items():
            here: Loc = ("places", len(places))
            self._origin(here, (*loc, number))
            if not number.isdecimal():
                rule = "the key must be a whole number"
                self._report((*loc, number), f"{rule}, got {shown(number)}")
                continue
            pose = self._numbers(
                point, (*loc, number), (*here, "pose"), heading=True
            )
            if pose is not None:
                names = {"name": f"goal_{number}", "id": int(number)}
                places.append({**names, "pose": pose})
                self._goals[int(number)] = pose[:2]

    def _tree(self, stem: str, number: Any) -> Path | None:
        """Returns the file of an agent's tree in HuNavSim 2, if it is there."""
        file = f"{stem}__agent_{number}_bt.xml"
        return _beside(Path(self.name).parent, "behavior_trees", file)

    def _add_agent(
        self, agent: dict[str, Any], name: str, loc: Loc, tree: Path | None
    ) -> None:
        humans = self.data["humans"]
        human: dict[str, Any] = {"name": name}
        here: Loc = ("humans", len(humans))
        humans.append(human)
        self._origin(here, loc)
        for key, field in HUMAN_FIELDS.items():
            self._origin((*here, field), (*loc, key))
            if key in agent:
                human[field] = agent[key]
            elif key in DEFAULTS:
                human[field] = DEFAULTS[key]
                if DEFAULTS[key] != getattr(_USUAL, field):
                    self._leave_out(
                        (*loc, key),
                        f"is missing; as in HuNavSim, {shown(DEFAULTS[key])}",
                    )
        for way, reason in left_out_of_agent(agent):
            self._leave_out((*loc, *way), reason)
        self._look_for_typing_errors(agent, loc)
        self._add_behavior(agent, human, loc, here)
        self._add_pose(agent, human, loc, here)
        self._add_goals(agent, human, loc, here)
        if tree is not None:
            human["behavior"] = str(tree)
            self._leave_out(
                (*loc, "behavior"), f"is its tree in {tree.parent.name}"
            )
            if _sets_goals(tree) and human.get("goals"):
                human["goals"] = []
                self._leave_out(
                    (*loc, "goals"), "are left out: its tree sets its goals"
                )

    def _add_behavior(
        self, agent: dict[str, Any], human: dict[str, Any], loc: Loc, here: Loc
    ) -> None:
        number = given = agent.get("behavior", 1)
        loc = (*loc, "behavior")
        at = loc
        if isinstance(given, dict):
            mode = self._choice(
                given.get("configuration", 0),
                FORCES_MODES,
                (*loc, "configuration"),
            )
            human["forces_mode"] = mode or "default"
            if mode == "custom":
                forces = human["forces"] = {}
                for key, field in FORCE_FIELDS.items():
                    self._origin((*here, "forces", field), (*loc, key))
                    if key in given:
                        forces[field] = given[key]
            number = given.get("type", 1)
            if isinstance(number, str):
                number = _NUMBERS.get(number.lower(), number)
            at = (*loc, "type")
        self._origin((*here, "behavior"), at)
        if behavior := self._choice(number, BEHAVIOR_NAMES, at):
            human["behavior"] = behavior
            if isinstance(given, dict):
                self._add_reaction(given, human, loc, (*here, "behavior"))

    def _add_reaction(
        self, given: dict[str, Any], human: dict[str, Any], loc: Loc, here: Loc
    ) -> None:
        """Adds the settings of a reaction in HuNavSim 2.0's files."""

        def tell(key: str, message: str) -> None:
            self._leave_out((*loc, key), message)

        count = len(self.data["humans"])
        ports = reaction_ports(human, given, count, tell)
        for port, (key, _) in ports.items():
            self._origin((*here, port), (*loc, key))
        if ports:
            values = {port: value for port, (_, value) in ports.items()}
            human["behavior"] = {"type": human["behavior"], **values}

    def _choice(
        self, number: Any, names: Mapping[int, str], loc: Loc
    ) -> str | None:
        """Returns the name of a number; reports an unknown one."""
        if type(number) is int and number in names:
            return names[number]
        known = ", ".join(f"{k} {v}" for k, v in names.items())
        self._report(loc, f"must be one of {known}; got {shown(number)}")
        return None

    def _add_pose(
        self, agent: dict[str, Any], human: dict[str, Any], loc: Loc, here: Loc
    ) -> None:
        loc, here = (*loc, "init_pose"), (*here, "pose")
        self._origin(here, loc)
        pose = self._numbers(agent.get("init_pose"), loc, here, heading=True)
        if pose is None:
            self._known.append(here)
        else:
            human["pose"] = pose

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
            if type(name) is int and name in self._goals:
                self._origin((*here, "goals", len(goals)), (*loc, "goals", i))
                goals.append(self._goals[name])
                continue
            if not isinstance(name, str) or name not in agent:
                problem = f"there is no goal {shown(name)}"
                self._report((*loc, "goals", i), problem)
                continue
            at: Loc = (*here, "goals", len(goals))
            self._origin(at, (*loc, name))
            goal = self._numbers(agent[name], (*loc, name), at)
            if goal is not None:
                goals.append(goal)

    def _numbers(
        self, point: Any, loc: Loc, here: Loc, *, heading: bool = False
    ) -> list[Any] | None:
        """Returns x, y and perhaps h of a point; reports missing ones."""
        if not isinstance(point, dict):
            rule = "must be a mapping with x and y"
            self._report(loc, f"{rule}, got {shown(point)}")
            return None
        missing = [key for key in ("x", "y") if key not in point]
        for key in missing:
            self._report((*loc, key), "is missing")
        if missing:
            return None
        keys = ("x", "y", "h") if heading else ("x", "y")
        for i, key in enumerate(keys):
            self._origin((*here, i), (*loc, key))
        return [point.get(key, 0.0) for key in keys]

    def _look_for_typing_errors(self, agent: dict[str, Any], loc: Loc) -> None:
        """Reports keys that are similar to known ones."""
        for key in agent:
            if key in AGENT_KEYS or len(key) > 20:
                continue
            near = nearest(key, AGENT_KEYS, 0.8)
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
            self._faults.append(
                Fault(
                    document.name,
                    0,
                    f"{node}.{_PARAMETERS}",
                    "is missing; the file has "
                    + (", ".join(map(shown, keys)) or "no keys"),
                )
            )
        raise ScenarioError(document.name, self._faults)

    def _set_time_step(self, period: float, usual: float, loc: Loc) -> None:
        """Sets a time step that divides a period."""
        # A period out of range is reported when the scenario is built.
        if not usual * 1e-3 <= period <= 60:
            return
        step = steps_for(period, usual)
        if step == usual:
            return
        self.data["simulation"] = {"time_step": step}
        cycle = max(1, round(PLANNERS.make().period / step)) * step
        self.data["planner"] = {"period": cycle}
        self._leave_out(
            loc,
            f"{period:.9g} s is not a number of steps of {usual:g} s;"
            f" simulation.time_step is {step:.9g} s, planner.period"
            f" {cycle:.9g} s",
        )

    def _leave_out(self, loc: Loc, reason: str) -> None:
        document = self._document
        if len(self.left_out) < _MAX_LEFT_OUT:
            place = document.name, document.line(loc)
            path = path_text(None, loc[2:])
            self.left_out.append(LeftOut(*place, path, reason, loc[2:]))

    def _origin(self, here: Loc, loc: Loc) -> None:
        self._origins[here] = (self._document, loc)

    def _report(self, loc: Loc, message: str) -> None:
        document = self._document
        path = path_text(None, loc[2:])
        line = document.line(loc)
        self._faults.append(Fault(document.name, line, path, message))


def _beside(folder: Path, other: str, name: str) -> Path | None:
    """Returns a file in a folder, or in another one in it or beside it."""
    for place in (".", other, f"../{other}"):
        if os.path.isfile(file := folder / place / name):
            return file.resolve()
    return None


_TREES = ("BehaviorTree", "SubTree", "SubTreePlus")

# What is raised for files that are no XML; the last two, for encodings.
_UNREADABLE = (
    OSError,
    ParseError,
    DefusedXmlException,
    ValueError,
    LookupError,
)


def _sets_goals(tree: Path) -> bool:
    """Returns whether the trees of a file set goals, those it includes too.

    What cannot be read is reported when the scenario is loaded.
    """
    left, seen = [tree], set()
    while left:
        file = left.pop()
        if file in seen:
            continue
        seen.add(file)
        with contextlib.suppress(*_UNREADABLE):
            root = parse(file).getroot()
            left += [
                (file.parent / it.get("path", "")).resolve()
                for it in root.iter("include")
            ]
            for behavior in root.iter("BehaviorTree"):
                for node in behavior.iter():
                    names = {node.tag, node.get("ID")}
                    # (Trees have an ID of their own.)
                    if "SetGoal" in names and names.isdisjoint(_TREES):
                        return True
    return False
