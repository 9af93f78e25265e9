"""A person's behavior: a name, a file, or XML, with values for its ports."""

import numpy as np
import pytest

from hunav_drake import MakeTrialDiagram, RunTrial
from hunav_drake.scenario import (
    BehaviorConfig,
    CheckScenario,
    HumanConfig,
    LoadScenario,
    SaveScenario,
    Scenario,
    ScenarioError,
)
from hunav_drake.systems.behavior import BehaviorTreeError, LoadBehavior
from hunav_drake.trial.humans import MakeHumans

# Looks at the robot from where it is, for as long as it is told.
XML = """\
<root BTCPP_format="4" main_tree_to_execute="Look">
  <BehaviorTree ID="Look">
    <Fallback>
      <Sequence>
        <Inverter>
          <TimeExpiredCondition seconds="{time}" only_once="{once}"/>
        </Inverter>
        <SurprisedNav turn_rate="{rate}"/>
      </Sequence>
      <RegularNav robot="{role}"/>
    </Fallback>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Look">
      <input_port name="time" type="double" default="2.0"/>
      <input_port name="once" type="bool" default="true"/>
      <input_port name="rate" type="double" default="1.0"/>
      <input_port name="role" type="std::string" default="obstacle"/>
    </SubTree>
  </TreeNodesModel>
</root>
"""
ROBOT = "robot: {start: [0, 5, 0]}\n"


def load_person(behavior, folder=None):
    """Loads a scenario of one person with that behavior, in YAML."""
    text = (
        f"{ROBOT}humans:\n  - pose: [0, 0, 0]\n    name: ana\n"
        f"    goals: [[9, 0]]\n    behavior: {behavior}\n"
    )
    if folder is None:
        return LoadScenario(data=text)
    (folder / "s.yaml").write_text(text)
    return LoadScenario(filename=folder / "s.yaml")


def constants(behavior, node):
    """Returns the ports of a node of a behavior's tree."""
    tree = LoadBehavior(behavior)
    (found,) = [it for it in tree.nodes if it.type.name == node]
    return {name: port.value for name, port in found.ports.items()}


class TestForms:
    def test_name(self):
        (human,) = load_person("curious").humans
        assert human.behavior == human.behavior_name == "curious"

    def test_name_with_ports(self):
        (human,) = load_person(
            "{type: curious, distance: 6.0, duration: 10}"
        ).humans
        assert human.behavior == BehaviorConfig(
            type="curious", ports={"distance": 6.0, "duration": 10}
        )
        assert human.behavior_name == "curious"
        visible = constants(human.behavior, "IsRobotVisible")
        assert visible["distance"] == 6.0
        assert visible["occlusion"] is True
        timer = constants(human.behavior, "TimeExpiredCondition")
        assert timer["seconds"] == 10.0

    def test_ports_in_a_mapping_of_their_own(self):
        flat = load_person("{type: curious, distance: 6.0}").humans
        own = load_person("{type: curious, ports: {distance: 6.0}}").humans
        assert own == flat

    def test_no_ports(self):
        (human,) = load_person("{type: scared}").humans
        assert human.behavior == BehaviorConfig(type="scared")

    @pytest.mark.parametrize("where", ["look.xml", "trees/look.xml"])
    def test_path_starts_at_the_scenario_file(
        self, where, tmp_path, monkeypatch
    ):
        monkeypatch.chdir("/")
        (tmp_path / "trees").mkdir()
        (tmp_path / where).write_text(XML)
        for behavior in (where, f"{{type: {where}, time: 3}}"):
            (human,) = load_person(behavior, tmp_path).humans
            assert human.behavior_name == "look"
            timer = constants(human.behavior, "TimeExpiredCondition")
            assert timer["seconds"] == (2.0 if behavior == where else 3.0)

    def test_absolute_path(self, tmp_path):
        (tmp_path / "look.xml").write_text(XML)
        (human,) = load_person(str(tmp_path / "look.xml")).humans
        assert constants(human.behavior, "SurprisedNav")["turn_rate"] == 1.0

    def test_xml(self):
        text = "|\n" + "".join(f"      {line}\n" for line in XML.splitlines())
        (human,) = load_person(text).humans
        assert human.behavior == XML
        assert human.behavior_name == "xml"
        assert constants(XML, "RegularNav")["robot"] == "obstacle"

    def test_xml_with_ports_of_each_type(self):
        config = BehaviorConfig(
            type=XML,
            ports={"time": 1, "once": False, "rate": 0.5, "role": "unseen"},
        )
        timer = constants(config, "TimeExpiredCondition")
        assert timer == {"seconds": 1.0, "only_once": False}
        assert constants(config, "SurprisedNav")["turn_rate"] == 0.5
        assert constants(config, "RegularNav")["robot"] == "unseen"

    def test_override_of_a_port_on_the_command_line(self):
        scenario = LoadScenario(
            filename="reaction_curious",
            overrides=[
                "humans[0].behavior={type: curious}",
                "humans[0].behavior.distance=7.0",
            ],
        )
        assert scenario.humans[0].behavior == BehaviorConfig(
            type="curious", ports={"distance": 7.0}
        )


class TestSaving:
    @pytest.mark.parametrize(
        "behavior",
        [
            "curious",
            BehaviorConfig(type="scared"),
            BehaviorConfig(
                type="curious", ports={"distance": 6.0, "only_once": False}
            ),
            XML,
            XML.replace("\n", " "),
            BehaviorConfig(type=XML, ports={"role": "unseen", "time": 3}),
        ],
        ids=["name", "no ports", "ports", "xml", "one line", "xml and ports"],
    )
    def test_saved_scenario_is_the_same(self, behavior):
        human = HumanConfig(
            pose=(0.0, 0.0, 0.0), name="ana", id=1, behavior=behavior
        )
        scenario = LoadScenario(
            data=ROBOT + SaveScenario(Scenario(humans=[human]))
        )
        assert scenario.humans == [human]
        assert LoadScenario(data=SaveScenario(scenario)) == scenario

    def test_file_is_found_from_elsewhere(self, tmp_path):
        (tmp_path / "look.xml").write_text(XML)
        scenario = load_person("look.xml", tmp_path)
        assert LoadScenario(data=SaveScenario(scenario)).humans == (
            scenario.humans
        )

    def test_ports_are_written_beside_the_tree(self):
        text = SaveScenario(load_person("{type: curious, distance: 6.0}"))
        assert "behavior:\n    type: curious\n    distance: 6.0\n" in text


FAULTS = {
    "unknown name": (
        "curius",
        "behavior: there is no behavior 'curius'; did you mean 'curious'?",
    ),
    "unknown name with ports": (
        "{type: curius, distance: 1}",
        "behavior.type: there is no behavior 'curius'",
    ),
    "unknown port": (
        "{type: curious, distence: 6}",
        "behavior.distence: there is no port 'distence'; did you mean"
        " 'distance'?",
    ),
    "ports of a tree without any": (
        "{type: '<root><BehaviorTree><RegularNav/></BehaviorTree></root>',"
        " distance: 6}",
        "behavior.distance: there is no port 'distance'; there is none",
    ),
    "range": (
        "{type: curious, distance: -6.0}",
        "behavior.distance: <IsRobotVisible>: port distance: must be in",
    ),
    "text for a number": (
        '{type: curious, distance: "6.0"}',
        "behavior.distance: must be a number, got '6.0'",
    ),
    "truth for a number": (
        "{type: curious, distance: true}",
        "behavior.distance: must be a number, got True",
    ),
    "number for a truth": (
        "{type: curious, only_once: 1}",
        "behavior.only_once: must be true or false, got 1",
    ),
    "number for a text": (
        "{type: curious, robot: 1}",
        "behavior.robot: must be a text, got 1",
    ),
    "unknown word": (
        "{type: curious, robot: cat}",
        "behavior.robot: <CuriousNav>: port robot: should be 'pedestrian'",
    ),
    "list": ("{type: curious, distance: [1]}", "must be a number, got [1]"),
    "nothing": ("{type: curious, distance: }", "must be a number, got None"),
    "huge": (
        f"{{type: curious, distance: {'9' * 400}}}",
        "behavior.distance: ",
    ),
    "no tree": ("{distance: 6.0}", "behavior.type: is missing"),
    "empty": ("{}", "behavior.type: is missing"),
    "tree of another type": ("{type: 3}", "behavior.type: must be text"),
    "number": ("3", "behavior: must be text, got 3"),
    "list of behaviors": ("[curious]", "behavior: must be text, got a list"),
    "port given twice": (
        "{type: curious, ports: {distance: 3.0}, distance: 4.0}",
        "the port distance is given twice, beside the type and in ports",
    ),
    "port of the person": (
        "{type: curious, id: 3}",
        "behavior.id: id cannot be set: it is the number of the person",
    ),
    "missing file": ("none.xml", "none.xml: there is no such file"),
    "folder": (".xml", "there is no such file"),
    "faulty xml": (
        '"<root>\\n<BehaviorTree><Regular/></BehaviorTree></root>"',
        "behavior:2: <Regular>: there is no node 'Regular'; did you mean",
    ),
    "no xml": ('"<root"', "behavior:1"),
    "include in xml": (
        '"<root><include path=\\"/etc/passwd\\"/></root>"',
        "cannot be found from a text",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_wrong_behavior_is_a_fault_at_its_place(name, tmp_path):
    behavior, words = FAULTS[name]
    with pytest.raises(ScenarioError) as caught:
        load_person(behavior, tmp_path)
    (fault,) = caught.value.faults
    assert words in f"{fault.path}: {fault.message}"
    assert fault.path.startswith("humans[0] ('ana').behavior")
    assert fault.source == str(tmp_path / "s.yaml")
    assert fault.line == 6


def test_all_wrong_ports_are_told_at_their_lines():
    text = (
        f"{ROBOT}humans:\n  - pose: [0, 0, 0]\n    behavior:\n"
        "      type: curious\n      distance: -1.0\n      speed: fast\n"
        "      duration: 3\n      turn: 3\n"
    )
    with pytest.raises(ScenarioError) as caught:
        LoadScenario(data=text)
    assert [
        (fault.line, fault.path.rpartition(".")[2])
        for fault in caught.value.faults
    ] == [(6, "distance"), (7, "speed"), (9, "turn")]


def test_thousands_of_wrong_ports_take_no_time():
    ports = ", ".join(f"p{i}: 1" for i in range(5000))
    with pytest.raises(ScenarioError) as caught:
        load_person(f"{{type: curious, {ports}}}")
    assert len(caught.value.faults) <= 20


def test_port_without_default_must_be_given():
    xml = XML.replace(' default="2.0"', "")
    with pytest.raises(BehaviorTreeError, match="needs a value for time"):
        LoadBehavior(xml)
    config = BehaviorConfig(type=xml, ports={"time": 4.0})
    assert constants(config, "TimeExpiredCondition")["seconds"] == 4.0


def test_scenario_made_in_python_is_checked():
    human = HumanConfig(
        pose=(0.0, 5.0, 0.0),
        behavior=BehaviorConfig(type="curious", ports={"distence": 1.0}),
    )
    with pytest.raises(ScenarioError, match="did you mean 'distance'"):
        CheckScenario(Scenario(humans=[human]))


def test_people_are_made_with_their_ports():
    dut = MakeHumans(
        [
            HumanConfig(
                pose=(0.0, 0.0, 0.0),
                behavior=BehaviorConfig(
                    type="surprised", ports={"distance": distance}
                ),
            )
            for distance in (1.0, 3.0)
        ]
    )
    context = dut.CreateDefaultContext()
    dut.GetInputPort("robot_states").FixValue(
        context, [2.0, 0, 0, 0, 0, 0, 0.35]
    )
    status = dut.GetOutputPort("behavior_status").Eval(context)
    assert status.tolist() == [0, 1]


def test_walls_of_the_world_hide_the_robot():
    text = (
        "world: {walls: [{type: box, center: [1.5, 0], size: [0.2, 2]}]}\n"
        "robot: {start: [3, 0, 0]}\n"
        "humans:\n  - pose: [0, 0, 0]\n    behavior: surprised\n"
        "  - pose: [3, 3, -1.57]\n    behavior: surprised\n"
    )
    diagram = MakeTrialDiagram(LoadScenario(data=text))
    status = diagram.GetOutputPort("behavior_status").Eval(
        diagram.CreateDefaultContext()
    )
    assert status.tolist() == [0, 1]


def test_result_names_the_behavior():
    scenario = LoadScenario(
        filename="reaction_curious",
        overrides=[
            "humans[0].behavior={type: curious, distance: 6.0}",
            "simulation.duration=0.5",
        ],
    )
    recording = RunTrial(scenario).recording
    assert recording.behaviors == ("curious",)
    assert np.isfinite(recording.humans).all()
