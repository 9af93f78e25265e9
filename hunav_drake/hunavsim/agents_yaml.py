"""Reads HuNavSim's own files: agents.yaml and metrics.yaml.

Both are parameter files of ROS 2 nodes. What they say about people becomes
HumanConfigs, what they say about metrics an EvaluatorConfig. Settings that
mean nothing here (the skins, the heights) are left out, and told.
"""

from pathlib import Path

from hunav_drake.hunavsim.agents_keys import BEHAVIOR_NAMES
from hunav_drake.hunavsim.hunav_import import AGENTS_KEY, HunavImport
from hunav_drake.hunavsim.import_notes import LeftOut
from hunav_drake.scenario.checks import OWN_CHECKS
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import read_yaml
from hunav_drake.systems.people.profile import ProfileName

__all__ = ["AGENTS_KEY", "BEHAVIOR_NAMES", "ImportAgents", "convert_agents"]


def ImportAgents(
    filename: str | Path,
    *,
    metrics_filename: str | Path | None = None,
    map_filename: str | Path | None = None,
    profile: ProfileName = "default",
    left_out: list[LeftOut] | None = None,
) -> Scenario:
    """Reads the people of HuNavSim's agents.yaml as a scenario.

    `max_vel` becomes the desired speed, and the behaviors become those of the
    same names. Whether they are available is not asked here: a scenario is
    checked for that when it is loaded or run. Of HuNavSim 2.0's settings of a
    behavior, the configuration becomes the `forces_mode`, and the factors of
    the forces are taken if that is custom (1), whatever they are. Durations,
    speeds and distances of reactions become ports of the behavior: as written
    (1), HuNavSim's (0), or drawn once by the person's number (2 and 3): see
    `hunav_drake.hunavsim.reactions`. What is missing is what HuNavSim takes for
    it: goals are cyclic, and `max_vel` is 1.0 m/s.

    The world of the result is the map that the file names, if there is such a
    file of map_server beside it, or the one that is given. The file says
    nothing about the robot: one of the default kind stands at (0, 0, 0)
    without a goal.

    Args:
        filename: The agents.yaml.
        metrics_filename: A metrics.yaml, whose frequency and chosen metrics
            become the evaluator's, and whose experiment tag is in the name; by
            default the evaluator is the default one. A frequency of 0 means
            every step. If it is not one of whole steps, as 30 Hz is, the time
            step becomes shorter.
        map_filename: The YAML file of a map, which is that of the world.
        profile: The profile of the crowd: "hunavsim" moves people as there.
        left_out: Gets what could not be carried over, with its places;
            `group_notes` makes few lines of it.

    Raises:
        ScenarioError: If a file cannot be read, or does not have that form.
            Each fault has its file, line and path.
    """
    imported = convert_agents(read_yaml(filename))
    imported.add_map(Path(filename).parent, map_filename)
    if metrics_filename is not None:
        imported.add_metrics(read_yaml(metrics_filename))
    if profile != "default":
        imported.data["crowd"] = {"profile": profile}
    if left_out is not None:
        left_out += imported.left_out
    return imported.build(OWN_CHECKS)


def convert_agents(document: YamlDocument) -> HunavImport:
    """Converts an agents.yaml to the data of a scenario.

    Raises:
        ScenarioError: If the list of agents itself cannot be read.
    """
    result = HunavImport(document)
    result.add_agents()
    return result
