"""Files of a session: saved as a whole, in their folder, and looked after."""

import os

import pytest

from hunav_drake.editor.files import FileRefusedError, SessionFile
from hunav_drake.editor.session import EditSession
from hunav_drake.scenario import LoadScenario
from tests.hunav_drake.editor.test_session import TEXT, View, kinds


@pytest.fixture
def path(tmp_path):
    result = tmp_path / "mine.yaml"
    result.write_bytes(TEXT.encode())
    return result


@pytest.fixture
def view(path):
    return View(EditSession(filename=path))


def rename(view, name):
    return view.edit(["set", ["humans", 0, "name"], name])


def test_save_writes_that_file_only(view, path):
    other = path.with_name("other.yaml")
    other.write_text("humans: []\n")
    rename(view, "eva")
    assert view.messages[-3]["dirty"]
    answers = view.ask("save")
    assert kinds(answers) == ["saved", "state"]
    assert not answers[1]["dirty"]
    assert path.read_text() == TEXT.replace("ana ", "eva ")
    assert sorted(it.name for it in path.parent.iterdir()) == [
        "mine.yaml",
        "other.yaml",
    ]
    assert other.read_text() == "humans: []\n"
    assert LoadScenario(filename=path) == view.session.scenario


def test_line_ends_and_the_mark_stay(path):
    text = b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode()
    path.write_bytes(text)
    view = View(EditSession(filename=path))
    rename(view, "eva")
    view.ask("save")
    assert path.read_bytes() == text.replace(b"ana ", b"eva ")


def test_faults_are_asked_about_once(view, path):
    view.edit(["set", ["humans", 0, "radius"], -1])
    (answer,) = view.ask("save")
    assert answer["kind"] == "ask"
    assert "1 fault" in answer["question"]
    assert path.read_text() == TEXT
    view.session.receive(answer["again"])
    assert "radius: -1" in path.read_text()


def test_another_file_is_not_overwritten_unasked(view, path):
    other = path.with_name("other.yaml")
    other.write_text("precious")
    (answer,) = view.ask("save", filename="other.yaml")
    assert "other.yaml already exists" in answer["question"]
    assert other.read_text() == "precious"
    view.session.receive(answer["again"])
    assert other.read_text() == TEXT
    assert path.read_text() == TEXT


def test_new_names_get_their_ending(view, path):
    view.ask("save", filename="new")
    assert path.with_name("new.yaml").read_text() == TEXT


@pytest.mark.parametrize(
    "name",
    [
        "../out.yaml",
        "/tmp/out.yaml",
        "link/out.yaml",
        "a/../../out.yaml",
        "page.py",
        "x\0.yaml",
        "no_such_folder/x.yaml",
        "x" * 3000 + ".yaml",
    ],
)
def test_nothing_is_written_elsewhere(view, path, name):
    (path.parent / "link").symlink_to(path.parents[1])
    for do in ("save", "open"):
        (answer,) = view.ask(do, filename=name)
        assert answer["kind"] == "error"
        assert "\n" not in answer["message"]
    assert not (path.parents[1] / "out.yaml").exists()
    assert sorted(it.name for it in path.parent.iterdir()) == [
        "link",
        "mine.yaml",
    ]


def test_a_file_changed_by_others_is_read_again(view, path):
    view.session.poll()
    path.write_text(TEXT.replace("ana", "zoe"))
    view.messages.clear()
    view.session.poll()
    assert view.data["humans"][0]["name"] == "zoe"
    assert "dirty" in view.messages[0]
    assert not view.messages[0]["dirty"]
    view.ask("undo")
    assert view.text == TEXT


def test_unsaved_edits_are_asked_about_once(view, path):
    rename(view, "eva")
    path.write_text(TEXT.replace("ana", "zoe"))
    view.messages.clear()
    view.session.poll()
    view.session.poll()
    (answer,) = view.messages
    assert answer["kind"] == "ask"
    assert view.data["humans"][0]["name"] == "eva"
    view.session.receive(answer["again"])
    assert view.data["humans"][0]["name"] == "zoe"
    view.ask("undo")
    assert view.data["humans"][0]["name"] == "eva"


def test_a_save_over_foreign_changes_is_asked(view, path):
    rename(view, "eva")
    path.write_text("# theirs\n")
    (answer,) = view.ask("save")
    assert "changed by another program" in answer["question"]
    assert path.read_text() == "# theirs\n"


def test_every_save_over_foreign_changes_is_asked(view, path):
    """Also after it was told that the file has changed, and one save."""
    rename(view, "eva")
    view.ask("save")
    rename(view, "ida")
    path.write_text("# theirs\n")
    view.session.poll()
    for _ in range(3):
        (answer,) = view.ask("save")
        assert "changed by another program" in answer["question"]
        view.session.poll()
    assert path.read_text() == "# theirs\n"
    view.session.receive(answer["again"])
    assert "ida" in path.read_text()
    rename(view, "eva")
    assert kinds(view.ask("save")) == ["saved", "state"]


def test_a_file_that_somebody_makes_meanwhile_is_asked_about(tmp_path):
    path = tmp_path / "new.yaml"
    view = View(EditSession(TEXT, filename=path))
    path.write_text("# theirs\n")
    (answer,) = view.ask("save")
    assert "changed by another program" in answer["question"]
    assert path.read_text() == "# theirs\n"


def test_touching_the_file_is_no_change(view, path):
    os.utime(path, (1, 1))
    view.messages.clear()
    view.session.poll()
    assert view.messages == []


def test_open_asks_for_what_is_not_saved(view, path):
    path.with_name("other.yaml").write_text("humans: []\n")
    rename(view, "eva")
    (answer,) = view.ask("open", filename="other.yaml")
    assert answer["kind"] == "ask"
    assert view.data["humans"]
    view.session.receive(answer["again"])
    assert view.data == {"humans": []}
    assert view.session.text == "humans: []\n"
    rename(view, "x")
    view.ask("save")
    assert path.read_text() == TEXT


def test_a_file_that_cannot_be_written(view, path, tmp_path):
    rename(view, "eva")
    path.unlink()
    path.mkdir()
    (answer,) = view.ask("save")
    assert answer["kind"] == "error"
    assert "cannot be written" in answer["message"]
    assert view.session.state.is_dirty


def test_a_new_scenario_needs_a_name(tmp_path):
    view = View(EditSession(folder=tmp_path))
    view.ask("template", name="office")
    (answer,) = view.ask("save")
    assert "file name" in answer["message"]
    view.ask("save", filename="first.yaml")
    saved = LoadScenario(filename=tmp_path / "first.yaml")
    assert len(saved.humans) == 2


def test_python_may_save_anywhere(view, tmp_path):
    elsewhere = tmp_path / "deep"
    elsewhere.mkdir()
    view.session.save(elsewhere / "copy.yml")
    assert (elsewhere / "copy.yml").read_text() == TEXT


@pytest.mark.parametrize("content", [b"\xff\xfe", b"x" * (16 * 2**20 + 1)])
def test_files_that_are_none_of_ours(tmp_path, content):
    path = tmp_path / "x.yaml"
    path.write_bytes(content)
    with pytest.raises(FileRefusedError, match=r"x\.yaml"):
        SessionFile(path).read()


def test_recorded_people_are_kept_and_need_no_pose(tmp_path):
    file = tmp_path / "mine.yaml"
    (tmp_path / "people.csv").write_text(
        "time,id,x,y\n" + "".join(f"{t},3,{t},1\n" for t in range(1, 9))
    )
    text = (
        "humans:\n"
        "  - {name: eva, pose: [0, 4, 0]}\n"
        "  - track: {file: people.csv, id: 3, on: 1.5}  # recorded\n"
        "population:\n"
        "  tracks: {file: people.csv, mode: blind, start: 1}\n"
        "robot: {start: [-3, -3, 0]}\n"
    )
    file.write_text(text)
    view = View(EditSession(filename=file))
    assert view.faults == []
    view.edit(["set", ["humans", 0, "pose"], [0, 5, 0]])
    view.ask("save")
    assert view.faults == []
    assert file.read_text() == text.replace("[0, 4, 0]", "[0, 5, 0]")
    assert view.session.scenario.humans[1].track.on == 1.5
