"""Reads HuNavSim's files agents.yaml and metrics.yaml.

Both are parameter files of ROS 2 nodes. The settings of people become
HumanConfigs, those of metrics an EvaluatorConfig. Settings without a meaning
here (skins, heights) are ignored and reported.
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

    `max_vel` becomes the desired speed, and behaviors become those of the same
    names. Their availability is checked when a scenario is loaded or run. The
    configuration of a behavior in HuNavSim 2.0 becomes the `forces_mode`. The
    factors of the forces are used if it is custom (1), without a limit.
    Durations, speeds and distances of reactions become ports of the behavior:
    the given values (1), HuNavSim's (0), or values drawn once by the person's
    number (2 and 3): see `hunav_drake.hunavsim.reactions`. Missing settings
    have the values of HuNavSim: goals are cyclic, and `max_vel` is 1.0 m/s.

    The `global_goals` of HuNavSim 2 become places by their numbers. The tree of
    an agent, <yaml_base_name>__agent_<id>_bt.xml, is its behavior if it is in
    the folder of the file, or in `behavior_trees` in or beside that folder; if
    it sets goals itself, the listed ones are left out.

    The world of the result is the given map, or the map that the file names if
    its map_server file is in the same folder, or in `maps` in or beside it. The
    file does not describe the robot: a default one stands at (0, 0, 0) without
    a goal.

    Args:
        filename: The agents.yaml.
        metrics_filename: A metrics.yaml, which gives the frequency and the
            metrics of the evaluator, and an experiment tag for the name; by
            default, the evaluator is the default one. A frequency of 0 means
            every step. The time step becomes shorter if the period is not a
            multiple of it, as with 30 Hz.
        map_filename: The YAML file of the map of the world.
        profile: The profile of the crowd: with "hunavsim", people move as in
            HuNavSim.
        left_out: Receives the settings that were not imported, with their
            places; `group_notes` summarizes them.

    Raises:
        ScenarioError: If a file cannot be read, or does not have that form.
            Each fault has its file, line and path.
    """
    imported = convert_agents(read_yaml(filename, number_keys=True))
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
