"""HuNavSim's files and other scenarios, taken over in one step."""

import json

import pytest

from hunav_drake.editor.session import EditSession
from tests.hunav_drake.editor.test_session import TEXT, View, kinds

AGENTS = """\
hunav_loader:
  ros__parameters:
    map: cafe
    agents:
      - ana
      - guide
    ana:
      id: 1
      skin: 0
      behavior: 5
      max_vel: 1.3
      radius: 0.4
      init_pose: {x: -3.0, y: 3.0, h: 1.5}
      goals: [g0]
      g0: {x: -3.0, y: -3.0, h: 1.25}
    guide:
      id: 2
      behavior: 2
      init_pose: {x: -1.0, y: 3.0}
      goals: []
"""
METRICS = """\
hunav_evaluator_node:
  ros__parameters:
    frequency: 10.0
    experiment_tag: '2'
    metrics:
      time_to_reach_goal: true
      path_length: true
      total_collisions: false
"""


@pytest.fixture
def view():
    return View(EditSession(TEXT))


def test_agents_replace_the_people(view):
    answers = view.ask(
        "import", kind="agents", mode="replace", name="agents.yaml", text=AGENTS
    )
    humans = view.data["humans"]
    assert [it["name"] for it in humans] == ["ana", "guide"]
    assert humans[0]["behavior"] == "curious"
    assert humans[0]["pose"] == [-3.0, 3.0, 1.5]
    assert "  # the block" in view.text
    assert view.faults == []
    assert answers[-1]["kind"] == "notes"
    assert any("skin" in it for it in answers[-1]["notes"])
    view.ask("undo")
    assert view.text == TEXT


def test_agents_are_added_under_free_names(view):
    view.edit(["set", ["humans", 0, "id"], 1])
    view.ask(
        "import", kind="agents", mode="add", name="agents.yaml", text=AGENTS
    )
    humans = view.data["humans"]
    names = [it["name"] for it in humans]
    assert names == ["ana", "ben", "ana_2", "guide"]
    assert [it.get("id") for it in humans] == [1, None, 2, 3]
    assert view.faults == []
    assert "# The second." in view.text


def test_groups_that_are_added_stay_apart_from_those_that_are_there():
    def people(*groups):
        return "humans:\n" + "".join(
            f"- {{pose: [{2 * i}, 0, 0], group_id: {group}}}\n"
            for i, group in enumerate(groups)
        )

    view = View(EditSession(people(0, 0, -1, 3)))
    text = people(0, 2, 0, -1, 3, 2)
    view.ask("import", kind="scenario", mode="add", name="more.yaml", text=text)
    groups = [it["group_id"] for it in view.data["humans"]]
    assert groups == [0, 0, -1, 3, *(1, 2, 1, -1, 4, 2)]


def test_agents_are_added_with_their_places(view):
    goals = "    global_goals: {3: {x: 1.0, y: 2.0}, 4: {x: 0.0, y: 2.0}}\n"
    text = AGENTS.replace("    agents:", f"{goals}    agents:", 1)
    mine = {"name": "goal_3", "id": 3, "pose": [1.0, 2.0, 0.0]}
    view.edit(["set", ["places"], [mine]])
    view.ask("import", kind="agents", mode="add", name="agents.yaml", text=text)
    assert view.data["places"] == [
        mine,
        {"name": "goal_4", "id": 4, "pose": [0.0, 2.0, 0.0]},
    ]
    assert view.faults == []


def test_faults_have_their_own_lines(view):
    wrong = AGENTS.replace("behavior: 5", "behavior: 9").replace(
        "y: -3.0, ", ""
    )
    (answer,) = view.ask(
        "import", kind="agents", mode="add", name="agents.yaml", text=wrong
    )
    assert answer["kind"] == "error"
    assert len(answer["faults"]) == 2
    assert answer["faults"][0].startswith("agents.yaml:10: ana.behavior")
    assert answer["faults"][1].startswith("agents.yaml:15: ")
    assert view.text == TEXT


def test_metrics_become_the_evaluators(view):
    view.edit(["set", ["evaluator"], {"profile": "paper"}])
    view.ask("import", kind="metrics", name="metrics.yaml", text=METRICS)
    assert view.data["evaluator"] == {
        "profile": "paper",
        "period": 0.1,
        "metrics": ["time_to_reach_goal", "path_length"],
    }
    assert len(view.data["humans"]) == 2


def test_scenarios_replace_with_their_comments(view):
    text = "# theirs\nhumans: []\n"
    view.ask("import", kind="scenario", name="theirs.yaml", text=text)
    assert view.text == text
    view.ask("undo")
    assert view.text == TEXT


@pytest.mark.parametrize("wrong", [{"a": 1}, [1], None, 1.5, True])
def test_people_are_added_beside_names_that_are_none(view, wrong):
    for key in ("name", "id"):
        view.edit(["set", ["humans", 0, key], wrong])
        other = json.dumps({"humans": [{"name": "ana", key: wrong}]})
        answers = view.ask(
            "import", kind="scenario", mode="add", name="o.yaml", text=other
        )
        assert "error" not in [it["kind"] for it in answers]
        assert view.data["humans"][-1].keys() >= {"name", key}


def test_scenarios_are_added(view):
    other = "humans: [{name: ana, pose: [8, 8, 0]}]\nworld:\n  furniture:\n"
    other += "    - {type: table, center: [9, 9]}\n"
    view.ask("import", kind="scenario", mode="add", name="o.yaml", text=other)
    assert len(view.data["humans"]) == 3
    assert view.data["world"]["furniture"] == [
        {"type": "table", "center": [9, 9]}
    ]
    assert len(view.data["world"]["walls"]) == 1


@pytest.mark.parametrize("kind", ["agents", "metrics", "scenario"])
@pytest.mark.parametrize("text", ["", "[", "- 1", "a: b", "\0", "x: &a [*a]"])
def test_other_files_are_refused(view, kind, text):
    answers = view.ask("import", kind=kind, name="x.yaml", text=text)
    if (kind, text) == ("scenario", "a: b"):
        # A fault of the scenario, which is shown where it is.
        assert "unknown key" in view.faults[0]["message"]
    else:
        assert kinds(answers) == ["error"]
        assert "x.yaml" in answers[0]["message"]
        assert view.text == TEXT
