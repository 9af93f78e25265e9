"""The widget of notebooks, without a browser: messages in and out."""

import dataclasses

import pytest

pytest.importorskip("anywidget", reason="the extra `editor` is not here")

from hunav_drake import EditScenario, LoadScenario, ScenarioError
from hunav_drake.editor.widget import modules_in_order
from tests.processes import run_python

PERSON = "humans:\n# The first one.\n- {name: ana, pose: [1, 2, 0]}\n"


@pytest.fixture
def make():
    made = []

    def make_editor(*args, **kwargs):
        made.append(EditScenario(*args, **kwargs))
        return made[-1]

    yield make_editor
    for editor in made:
        editor.close()


def _edit(editor, *ops):
    base = editor._session.state.revision
    message = {"do": "edit", "id": 1, "base": base, "label": "x", "ops": ops}
    editor._receive(editor, message, [])


def test_a_text_is_edited_and_keeps_its_comments(make):
    editor = make(PERSON)
    _edit(editor, ["set", ["humans", 0, "pose"], [3.0, 4.0, 0.0]])
    assert editor.scenario.humans[0].pose == (3.0, 4.0, 0.0)
    assert "# The first one." in editor.text


def test_a_scenario_made_in_python_stays_as_it_is(make):
    scenario = LoadScenario(filename="passing")
    before = dataclasses.asdict(scenario)
    editor = make(scenario)
    _edit(editor, ["set", ["robot", "radius"], 0.5])
    assert dataclasses.asdict(scenario) == before
    assert editor.scenario.robot.radius == 0.5


def test_shipped_scenarios_and_files_are_opened(make, tmp_path):
    assert make("cafe").scenario.humans[0].name == "alba"
    file = tmp_path / "mine.yaml"
    file.write_text(PERSON)
    assert make(file).scenario.humans[0].name == "ana"
    assert make(str(file)).text == PERSON


def test_nothing_is_written_but_by_save(make, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(PERSON)
    editor = make(file)
    _edit(editor, ["set", ["humans", 0, "name"], "bo"])
    assert file.read_text() == PERSON
    editor.save()
    assert LoadScenario(filename=file).humans[0].name == "bo"
    assert [it.name for it in tmp_path.iterdir()] == ["mine.yaml"]


def test_a_name_of_nothing_is_an_error(make):
    with pytest.raises(ValueError, match="shipped scenario 'cofe'"):
        make("cofe")


def test_faults_keep_the_scenario_back(make):
    editor = make(PERSON)
    _edit(editor, ["set", ["humans", 0, "desired_speed"], -1.0])
    (fault,) = editor.faults
    assert fault["path"] == ["humans", 0, "desired_speed"]
    with pytest.raises(ScenarioError):
        _ = editor.scenario


def test_changes_are_told_once_each(make):
    editor = make(PERSON)
    names = []
    end = editor.on_change(lambda it: names.append(it.scenario.humans[0].name))
    _edit(editor, ["set", ["humans", 0, "name"], "bo"])
    _edit(editor, ["set", ["humans", 0, "name"], "cy"])
    end()
    _edit(editor, ["set", ["humans", 0, "name"], "di"])
    assert names == ["bo", "cy"]


def test_no_process_is_started_before_it_is_shown(make):
    editor = make(PERSON)
    assert editor._worker._first is None
    assert editor.results == []
    assert "hunav edit" in repr(editor)


def test_a_file_of_no_run_is_not_given(make):
    editor = make(PERSON)
    sent = []
    editor.send = lambda content, buffers=None: sent.append(content)
    editor._receive(editor, {"do": "result_file", "run": 1, "name": "../x"}, [])
    assert sent == [{"kind": "error", "message": "The file does not exist."}]


def test_modules_come_after_those_that_they_import():
    seen = set()
    for name, text in modules_in_order():
        for line in text.splitlines():
            if line.startswith("import "):
                other = line.split('"')[1].removeprefix("./")
                assert other in seen, (name, other)
        seen.add(name)
    assert "editor.js" in seen
    assert "runs.js" in seen
    assert "page.js" not in seen


@pytest.mark.slow
def test_without_anywidget_the_remedy_is_told():
    code = (
        "import sys\n"
        "sys.modules['anywidget'] = None\n"
        "import hunav_drake\n"
        "assert 'EditScenario' in dir(hunav_drake)\n"
        "try:\n"
        "    hunav_drake.EditScenario('cafe')\n"
        "except ImportError as error:\n"
        "    print(error)\n"
    )
    done = run_python(code)
    assert done.stdout.splitlines() == [
        "EditScenario needs anywidget: pip install 'hunav_drake[editor]'"
    ]
