import json
import shutil
from xml.etree import ElementTree

import pytest

from hunav_drake.editor.worker.catalog import (
    behavior_entry,
    make_catalog,
    metric_entries,
)
from hunav_drake.systems.behavior import (
    ACTIVITIES,
    BEHAVIORS,
    CheckBehavior,
    ParseTree,
)
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.people.behavior_choice import BehaviorConfig


@pytest.fixture(scope="module")
def catalog():
    return make_catalog()


@pytest.mark.slow
def test_it_is_plain_data(catalog):
    assert json.loads(json.dumps(catalog, allow_nan=False)) == catalog


def test_all_behaviors_are_told_apart(catalog):
    entries = catalog["behaviors"]
    assert [it["name"] for it in entries] == [*BEHAVIORS, *ACTIVITIES]
    assert len({it["letter"] for it in entries}) == len(entries)
    # (Activities are gray, as trees of people's own are.)
    colors = [it["color"] for it in entries]
    assert len(set(colors[: len(BEHAVIORS)])) == len(BEHAVIORS)
    assert len(set(colors[len(BEHAVIORS) :])) == 1
    assert all(len(it["help"]) > 20 for it in entries)


@pytest.mark.parametrize("name", BEHAVIORS)
def test_defaults_of_ports_can_be_given(catalog, name):
    (entry,) = [it for it in catalog["behaviors"] if it["name"] == name]
    ports = {it["name"]: it["default"] for it in entry["ports"]}
    assert ports
    assert not [*CheckBehavior(BehaviorConfig(type=name, ports=ports))]


def test_ports_have_help_unit_and_range(catalog):
    (curious,) = [it for it in catalog["behaviors"] if it["name"] == "curious"]
    ports = {it["name"]: it for it in curious["ports"]}
    assert ports["distance"]["default"] == 10.0
    assert ports["distance"]["type"] == "number"
    assert ports["track"]["default"] is True
    assert "CuriousNav" in ports["stop_distance"]["help"]
    assert all(it["help"] for it in curious["ports"])
    assert set(ports["robot"]["schema"]["enum"]) >= {"unseen", "obstacle"}


def test_a_port_without_a_default_has_to_be_given():
    tree = """
      <root BTCPP_format="4" main_tree_to_execute="Mine">
        <!-- Not at the head. -->
        <BehaviorTree ID="Mine">
          <IsRobotVisible distance="{far}"/>
        </BehaviorTree>
        <TreeNodesModel><SubTree ID="Mine">
          <input_port name="far" type="double"/>
        </SubTree></TreeNodesModel>
      </root>"""
    tree = ParseTree(tree, ports={"far": 3.0})
    entry = behavior_entry("mine", tree, "#000000")
    (port,) = entry["ports"]
    assert port["required"]
    assert port["default"] is None
    assert entry["help"] == ""


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
def test_pictures_are_svg_without_scripts(catalog):
    for entry in catalog["behaviors"]:
        root = ElementTree.fromstring(entry["picture"])
        assert root.tag.endswith("svg")
        assert "script" not in {it.tag.rpartition("}")[2] for it in root.iter()}


def test_all_metrics_are_defined(catalog):
    entries = {it["name"]: it for it in catalog["metrics"]}
    assert set(entries) == set(METRICS)
    assert all(it["definition"] and it["unit"] for it in entries.values())
    paper = [name for name, it in entries.items() if it["paper"]]
    assert paper == [it.name for it in select_metrics(["paper"])]


def test_a_metric_of_the_user_is_there(restored_metrics):
    from hunav_drake.systems.evaluation.metrics import register_metric

    @register_metric(unit="s", family="mine", source="me")
    def my_own(recording):
        """The last time."""
        return float(recording.times[-1])

    (entry,) = [it for it in metric_entries() if it["name"] == "my_own"]
    assert entry["family"] == "mine"
    assert entry["definition"] == "The last time."


def test_choices_have_words_and_parameters(catalog):
    planners = {it["name"]: it for it in catalog["planners"]}
    assert {"pursuit", "dwb"} <= set(planners)
    assert all(it["help"] for it in planners.values())
    assert "cruise_speed" in planners["pursuit"]["parameters"]["properties"]
    assert "social_force" in {it["name"] for it in catalog["models"]}
    assert catalog["robots"]
