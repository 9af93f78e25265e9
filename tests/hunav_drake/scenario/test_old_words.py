"""The words before `type`: read with a note, and written anew by --fix."""

from pathlib import Path
import re

import pytest

from hunav_drake import HumanConfig, LoadScenario, Scenario, ScenarioError
from hunav_drake.commands.cli import main
from hunav_drake.editor.session import EditSession
from hunav_drake.runs import LoadSuite
from hunav_drake.scenario import templates
from hunav_drake.scenario.old_words import renewed_text
from hunav_drake.scenarios import shipped_names, shipped_text
from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.people.behavior_choice import BehaviorConfig
from hunav_drake.systems.planning import PLANNERS
from hunav_drake.systems.robot import ROBOTS
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import WALLS

OLD = """\
# Two people.
planner:   {name: dwb}  # the first of the paper
robot:
  "model": pmb2   # heavy

  goal: [3, 0, 0]
crowd: {model: {name: orca, time_horizon: 2.0}}
world:
  walls:
  - &wall {shape: box, center: [0,5], size: [10,.2]} # north
  - {<<: *wall, center: [0, -5]}
  furniture:
  - kind:   table
    center: [1.5, 3]
humans:
- {name: ana, pose: [3, 2, 0], behavior: {tree: curious, distance: 3}}
- {pose: [-3, 0, 0], behavior: curious}
"""
NEW = (
    OLD.replace("{name: dwb}", "{type: dwb}")
    .replace('"model"', "type")
    .replace("{name: orca", "{type: orca")
    .replace("shape", "type")
    .replace("kind", "type")
    .replace("tree", "type")
)


def as_before(text):
    """Returns a shipped scenario as it was written with the old words."""
    for word, names in (
        ("shape", WALLS),
        ("kind", FURNITURE),
        ("model", ROBOTS),
        ("name", [*PLANNERS, *MOTION_MODELS]),
    ):
        # (Places had no old words.)
        text = re.sub(
            rf"type: (?=({'|'.join(names)})\b(?!, pose))", f"{word}: ", text
        )
    return text.replace("behavior: {type:", "behavior: {tree:")


def shipped_texts():
    folder = Path(templates.__file__).parent
    texts = {it.name: it.read_text() for it in folder.glob("*.yaml")}
    for name in shipped_names():
        text = shipped_text(name)
        texts[name] = text if isinstance(text, str) else text.decode()
    return texts


@pytest.mark.parametrize(("name", "text"), shipped_texts().items())
def test_what_is_shipped_is_written_anew_as_it_is(name, text):
    old = as_before(text)
    assert old != text
    new, words = renewed_text(old.encode(), name)
    assert new == text.encode()
    assert words.total() == sum(
        one != other
        for one, other in zip(old.split("\n"), text.split("\n"), strict=True)
    )


@pytest.mark.parametrize("name", ["combined", "cafe"])
def test_old_words_are_read_with_one_note(name):
    new = shipped_texts()[name]
    with pytest.warns(FutureWarning) as notes:
        read = LoadScenario(data=as_before(new))
    assert read == LoadScenario(data=new)
    (note,) = notes
    assert re.search(
        r"data:\d+: world.walls\[0\] \('north'\).shape: is now 'type', and so"
        r" are \d+ other old words; `hunav check --fix FILE`",
        str(note.message),
    )


def test_lines_of_faults_are_those_of_old_words():
    text = "planner:\n\n  name: nobody\n"
    with (
        pytest.warns(FutureWarning, match=r"data:3: planner\.name: is now"),
        pytest.raises(ScenarioError, match=r"data:3: planner\.type: there is"),
    ):
        LoadScenario(data=text)


@pytest.mark.parametrize(
    "setting",
    [
        "robot.model=pmb2",
        "robot={model: pmb2}",
        "planner.name=pursuit",
        "world.walls=[{shape: box, center: [9, 9], size: [1, 1]}]",
        "humans[0].behavior={tree: curious}",
        "humans[0].behavior.tree=curious",
    ],
)
def test_settings_may_have_old_words(setting):
    new = re.sub(r"model|name|shape|tree", "type", setting, count=1)
    data = "humans: [{pose: [3, 2, 0], behavior: {type: scared}}]"
    with pytest.warns(FutureWarning, match=r"--set .* is now 'type'; write"):
        read = LoadScenario(data=data, overrides=[setting])
    assert read == LoadScenario(data=data, overrides=[new])


def test_an_old_word_is_replaced_by_a_setting():
    settings = ["planner.type=sfw", "robot.model=differential_drive"]
    with pytest.warns(FutureWarning):
        read = LoadScenario(data=OLD, overrides=settings)
    assert read == LoadScenario(
        data=NEW,
        overrides=["planner=sfw", settings[1].replace("model", "type")],
    )


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("planner: {type: dwb,\n  name: dwb}", r"data:2: planner\.name"),
        ("robot:\n  type: pmb2\n  model: pmb2", r"data:3: robot\.model"),
        (
            "world:\n walls:\n - {type: box, shape: box, center: [0, 0],"
            " size: [1, 1]}",
            r"data:3: world\.walls\[0\]\.shape",
        ),
        (
            "humans:\n- {pose: [0, 0, 0], behavior: {type: scared, tree: x}}",
            r"data:2: humans\[0\]\.behavior: tree",
        ),
    ],
)
def test_both_words_are_a_fault(text, place):
    with pytest.raises(ScenarioError, match=f"{place}:? is the old word"):
        LoadScenario(data=text)


def test_python_reads_old_words_too():
    with pytest.warns(FutureWarning, match="'name' of a planner is now 'type'"):
        scenario = Scenario(planner={"name": "dwb"})
    assert scenario.planner == PLANNERS.make("dwb")
    with pytest.warns(FutureWarning, match="'tree' of a behavior"):
        config = BehaviorConfig(tree="scared", ports={"memory": 1.0})
    assert config.type == config.tree == "scared"
    with pytest.warns(FutureWarning):
        human = HumanConfig(pose=(0, 0, 0), behavior={"tree": "scared"})
    assert human.behavior == BehaviorConfig(type="scared")


def test_a_suite_may_have_old_words():
    text = "scenarios: [passing]\nplanners:\n- {name: dwb, label: own}\n"
    with pytest.warns(FutureWarning, match=r"data:3: planners\[0\].*\.name"):
        suite = LoadSuite(data=text)
    assert suite == LoadSuite(data=text.replace("name", "type"))


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_a_file_is_rewritten_in_place(tmp_path, capsys, newline, mark):
    file = tmp_path / "own.yaml"
    file.write_bytes(mark + OLD.replace("\n", newline).encode())
    assert main(["check", "--fix", str(file)]) == 0
    assert file.read_bytes() == mark + NEW.replace("\n", newline).encode()
    out = capsys.readouterr().out
    assert "wrote 'type' for old words: 'name' 2, 'model' 1, 'shape' 2" in out
    assert out.splitlines()[1].startswith(f"{file}: ok (2 people")
    before = file.stat()
    assert main(["check", "--fix", str(file)]) == 0
    assert file.stat() == before


def test_all_scenarios_of_a_file_are_rewritten():
    inner = "".join(f"  {line}\n" for line in OLD.splitlines())
    text = f"one:\n{inner}two: {{planner: {{name: sfw}}}}\n"
    new, words = renewed_text(text.encode(), "several")
    inner = "".join(f"  {line}\n" for line in NEW.splitlines())
    wanted = f"one:\n{inner}two: {{planner: {{type: sfw}}}}\n"
    assert new.decode() == wanted
    assert words == {"name": 3, "model": 1, "shape": 2, "kind": 1, "tree": 1}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"planner: {name: dwb", "is not YAML"),
        (b"planner: {name: dwb}\nplanner: {}", "given twice"),
        (b"planner: {name: \xff}", "is not UTF-8"),
        (
            b"a: {robot: {}, own: &it {name: dwb}}\nb: {planner: *it}",
            ":2: b.planner.name: is now 'type'; write it yourself",
        ),
    ],
)
def test_what_cannot_be_rewritten_stays(tmp_path, capsys, text, words):
    file = tmp_path / "own.yaml"
    file.write_bytes(text)
    assert main(["check", "--fix", str(file)]) == 2
    assert words in capsys.readouterr().err
    assert file.read_bytes() == text


def test_a_file_that_is_not_there_is_told(capsys):
    assert main(["check", "--fix", "pasing.yaml"]) == 2
    assert "pasing.yaml: No such file" in capsys.readouterr().err


def test_shipped_scenarios_need_no_fix(capsys):
    assert main(["check", "--fix", "passing"]) == 0
    assert "passing: ok" in capsys.readouterr().out


def test_the_editor_opens_old_words_as_new_ones(tmp_path):
    file = tmp_path / "own.yaml"
    file.write_text(OLD)
    session = EditSession(filename=file)
    assert session.text == NEW
    assert session.state.is_dirty
    assert not session.faults
    session.receive({"do": "undo"})
    assert session.text == OLD
    warning = session.faults[0]
    assert (warning["severity"], warning["line"]) == ("warning", 2)
    assert warning["path"] == ["planner", "name"]
    assert warning["fix"]["label"] == "Rename it to type"
    session.receive({"do": "redo"})
    session.save()
    assert file.read_text() == NEW
