import pytest

from hunav_drake.editor.worker.requests import Run, RunRequest
from hunav_drake.editor.worker.results import ResultFolder


def _run(number, folder=None):
    request = RunRequest(text="")
    return Run(
        number=number, request=request, seed=0, planner=None, folder=folder
    )


@pytest.fixture
def results(tmp_path):
    folder = tmp_path / "runs" / "one"
    folder.mkdir(parents=True)
    for name in ("report.html", "result.json"):
        (folder / name).write_text(name)
    dut = ResultFolder(tmp_path)
    dut.add([_run(1, folder), _run(2)])
    yield dut
    dut.close()


def test_files_of_the_list_are_given(results):
    path = results.file(results.token, "1", "report.html")
    assert path.read_text() == "report.html"


@pytest.mark.parametrize(
    ("run", "name"),
    [
        ("1", "result.json"),
        ("1", "replay.html"),
        ("1", "../one/report.html"),
        ("1", "/etc/passwd"),
        ("2", "report.html"),
        ("3", "report.html"),
        ("-1", "report.html"),
        ("1" * 5000, "report.html"),
        ("", ""),
    ],
)
def test_nothing_else_is_given(results, run, name):
    assert results.file(results.token, run, name) is None


@pytest.mark.parametrize("token", ["", "wrong", "é"])
def test_a_wrong_token_gets_nothing(results, token):
    assert results.file(token, "1", "report.html") is None


def test_addresses_name_files_that_are_there(results):
    one, two = results._runs.values()
    urls = results.urls(one)
    assert urls["report_url"] == f"results/{results.token}/1/report.html"
    assert urls["replay_url"] is None
    assert set(results.urls(two).values()) == {None}


def test_a_temporary_folder_is_removed_in_the_end():
    dut = ResultFolder(None)
    path = dut.path
    assert path.is_dir()
    assert dut.given is None
    dut.close()
    assert not path.exists()


def test_a_chosen_folder_stays(results, tmp_path):
    results.close()
    assert (tmp_path / "runs" / "one" / "report.html").exists()
