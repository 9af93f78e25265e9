"""What `hunav report` makes of the folders of all commands."""

import json
import shutil

import pandas as pd
import pytest

from hunav_drake.commands import cli, report
from hunav_drake.report.plots import plot_comparison
from hunav_drake.report.suite_files import WriteSuite
from hunav_drake.runs import LoadSuite, RunSuite, WriteResult
from hunav_drake.runs.comparison.tables import COLUMNS
from hunav_drake.runs.suite_tables import WriteSuiteTables
from tests.hunav_drake.passing_trials import make_result
from tests.hunav_drake.runs import made_runs

SUITE = """
name: two
scenarios: [crossing]
planners: [pursuit, {type: pursuit, cruise_speed: 0.4, label: slow}]
overrides: [simulation.duration=0.5]
seeds: 2
"""


@pytest.fixture(scope="module")
def suite_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("two")
    RunSuite(LoadSuite(data=SUITE), out=folder, workers=1)
    return folder


@pytest.fixture
def runs_folder(tmp_path):
    for planner in ("pursuit", "dwb"):
        for seed in range(3):
            WriteResult(make_result(planner=planner, seed=seed), tmp_path)
    return tmp_path


def test_a_suite_writes_its_tables(suite_folder):
    """`report.html` is added by `hunav bench`, `hunav report`, WriteSuite."""
    assert {it.name for it in suite_folder.iterdir()} == {
        *("runs.jsonl", "runs.csv", "runs_by_behavior.csv", "summary.csv"),
        *("outcomes.csv", "relations.csv", "costs.csv", "suite.json"),
        *("tables.tex", "recordings"),
    }
    runs = pd.read_csv(suite_folder / "runs.csv")
    assert list(runs["planner"]) == ["pursuit", "pursuit", "slow", "slow"]
    assert len(plot_comparison(runs).patches) == 2
    tex = (suite_folder / "tables.tex").read_text()
    assert "planners pursuit and slow;" in tex
    assert "suite two, version 1; hunav\\_drake" in tex


def test_a_page_of_other_runs_does_not_stay(tmp_path):
    runs = made_runs.runs_of([10.0, 11.0])
    page = WriteSuite(made_runs.make_result({("hall", "a"): runs}), tmp_path)
    assert "10.5" in page.read_text()
    other = made_runs.make_result({("hall", "a"): made_runs.runs_of([3.25])})
    WriteSuiteTables(other, tmp_path)
    assert not page.exists()
    assert "3.25" in WriteSuite(other, tmp_path).read_text()


@pytest.mark.slow
def test_a_suite_may_have_no_recordings(suite_folder, tmp_path, capsys):
    folder = shutil.copytree(suite_folder, tmp_path / "two")
    damaged = folder / "recordings" / "crossing_slow_0.npz"
    damaged.write_bytes(b"")
    assert cli.main(["report", str(folder)]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"hunav: {damaged}: is not a recording, or is")
    assert "; delete it, and the report has no plot of this run\n" in told
    # Only the log was copied.
    shutil.rmtree(folder / "recordings")
    (folder / "suite.json").unlink()
    assert cli.main(["report", str(folder)]) == 0
    assert "the report on 4 runs" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("fresh", [True, False])
def test_a_suite_that_goes_on_is_unfinished_until_its_end(
    suite_folder, tmp_path, capsys, fresh
):
    folder = shutil.copytree(suite_folder, tmp_path / "two")

    def interrupt(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        RunSuite(
            LoadSuite(data=SUITE.replace("seeds: 2", "seeds: 3")),
            out=folder,
            workers=1,
            fresh=fresh,
            progress=interrupt,
        )
    runs = len((folder / "runs.jsonl").read_text().splitlines())
    assert runs == (3 if fresh else 5)
    assert cli.main(["report", str(folder)]) == 0
    assert f"the report on {runs} runs" in capsys.readouterr().out
    assert "unfinished" in (folder / "report.html").read_text()


@pytest.mark.slow
def test_figures_and_tables_of_a_suite(suite_folder, tmp_path, capsys):
    latex, figures = tmp_path / "mine.tex", tmp_path / "figures"
    words = ["report", str(suite_folder), "--metrics", "path_length"]
    words += ["--columns", "mean", "sd", "--latex", str(latex)]
    assert cli.main([*words, "--figures", str(figures)]) == 0
    out = capsys.readouterr().out
    assert f"Wrote the tables for LaTeX to {latex}" in out
    assert f"Wrote 9 files of figures to {figures / 'figures.tex'}" in out
    assert (suite_folder / "report.html").is_file()
    text = latex.read_text()
    assert r"\multicolumn{2}{c}{slow}" in text
    assert text.count(r"path\_length &") == 1
    assert "suite two, version 1; hunav\\_drake" in text
    tex = (figures / "figures.tex").read_text()
    assert "suite two, version 1; hunav\\_drake" in tex
    assert len(list(figures.glob("crossing_path_length_*.pdf"))) == 3


def test_tables_of_single_runs(runs_folder, tmp_path, capsys):
    latex = tmp_path / "mine.tex"
    assert cli.main(["report", str(runs_folder), "--latex", str(latex)]) == 0
    text = latex.read_text()
    assert "planners dwb and pursuit; 3 seeds (0 to 2); hunav\\_drake" in text
    # Those of the headline.
    assert r"min\_dist\_to\_people & " in text
    assert "Wrote the report on 6 runs" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["--metrics", "path_length"], "add --figures DIR or --latex FILE"),
        (["--columns", "mean"], "add --latex FILE"),
        (
            ["--columns", "mean", "--figures", "f"],
            "--columns chooses those of a table: add --latex FILE",
        ),
        (
            ["--metrics", "path_lenth", "--latex", "t.tex"],
            "no metric 'path_lenth'; did you mean 'path_length'",
        ),
        (["--latex", "no/t.tex"], "there is no folder no"),
    ],
)
def test_what_would_do_nothing_is_refused(
    runs_folder, words, fault, capsys, monkeypatch
):
    monkeypatch.chdir(runs_folder)
    before = {it.name for it in runs_folder.iterdir()}
    assert cli.main(["report", str(runs_folder), *words]) == 2
    assert fault in capsys.readouterr().err
    # Nothing was written before.
    assert {it.name for it in runs_folder.iterdir()} == before


def test_the_columns_of_the_command_are_those_of_tables():
    assert (*COLUMNS,) == report._COLUMNS


@pytest.mark.parametrize(
    ("files", "told"),
    [
        (["tried.csv", "search.json", "001.npz"], "`hunav falsify` found"),
        (["tried.csv", "search.json", "rank.csv"], "tried.csv: none failed"),
        (
            ["search.json", "runs.jsonl"],
            "log of `hunav falsify` or `hunav risk",
        ),
        (["who.csv", "runs/"], "pandas.read_csv("),
        (["validation.html", "numbers.csv"], "open {folder}/validation.html"),
        (["metadata.yaml", "bag.mcap"], "`hunav evaluate {folder} --out DIR`"),
        (["result.json", "recording.npz"], "is a single run; give the folder"),
        (["run_1/result.json"], "`hunav report {parent}`"),
        (["crossing_dwb_0.npz"], "has recordings; `hunav evaluate FILE"),
        (["rooms_0.yaml"], "has scenarios; `hunav run FILE --out DIR`"),
        (["mine/runs.jsonl"], "There are some in mine."),
        ([], "No results are there"),
    ],
)
def test_a_folder_without_runs_is_told_by_what_it_has(
    files, told, tmp_path, capsys
):
    for name in files:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        if name.endswith("/"):
            path.mkdir()
        else:
            path.write_text("")
    assert cli.main(["report", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert told.format(folder=tmp_path, parent=tmp_path.parent) in error
    assert not (tmp_path / "report.html").exists()


def test_branches_and_a_file(runs_folder, capsys):
    """What `hunav branch` writes beside its runs does not hide them."""
    (runs_folder / "branches.csv").write_text("")
    (runs_folder / "who.csv").write_text("")
    assert cli.main(["report", str(runs_folder)]) == 0
    path = runs_folder / "runs.csv"
    assert cli.main(["report", str(path)]) == 2
    assert "is a file, and reports are on folders" in capsys.readouterr().err


def test_a_suite_without_page_has_its_facts_in_json(suite_folder):
    about = json.loads((suite_folder / "suite.json").read_text())
    assert about["suite"] == "two"
    assert len(about["cells"]) == 2


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("suite.json", '{"suite"'),
        ("suite.json", "[]"),
        ("suite.json", '{"relations": [], "facts": []}'),
        ("runs.csv", "scenario,planner\ncrossing,pursuit\n"),
        ("costs.csv", "scenario,planner,setting,seed,end_time\n"),
        ("costs.csv", ""),
    ],
)
def test_damaged_tables_of_a_suite_are_told(
    suite_folder, name, text, tmp_path, capsys
):
    shutil.copytree(suite_folder, tmp_path, dirs_exist_ok=True)
    (tmp_path / name).write_text(text)
    assert cli.main(["report", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"hunav: {tmp_path / 'suite.json'}: is damaged, or")
    assert "delete it and start the suite again" in told


def test_a_damaged_line_of_the_log_of_single_runs_is_told(runs_folder, capsys):
    log = runs_folder / "runs.jsonl"
    log.write_text(log.read_text().replace('"seed": 1', '"seed": "x"', 1))
    assert cli.main(["report", str(runs_folder)]) == 2
    told = capsys.readouterr().err
    assert f"{log}:2: is damaged" in told
    assert "seed: must be a whole number" in told
    assert "bug" not in told


def test_single_runs_in_the_folder_of_a_suite_are_told(
    suite_folder, tmp_path, capsys
):
    shutil.copytree(suite_folder, tmp_path, dirs_exist_ok=True)
    WriteResult(make_result(), tmp_path, tag="mine")
    assert cli.main(["report", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "report on 4 runs" in out
    told = f"left out runs in {tmp_path / 'runs'} that are not of the suite"
    assert f"{told}: mine;" in err
    (tmp_path / "moved").mkdir()
    (tmp_path / "runs").rename(tmp_path / "moved" / "runs")
    assert cli.main(["report", str(tmp_path)]) == 0
    assert cli.main(["report", str(tmp_path / "moved")]) == 0
    out, err = capsys.readouterr()
    assert "report on 1 run " in out
    assert not err


@pytest.mark.slow
def test_the_page_of_a_suite_is_named_after_its_folder(
    suite_folder, tmp_path, monkeypatch
):
    folder = tmp_path / "moved"
    shutil.copytree(suite_folder, folder)
    monkeypatch.chdir(folder)
    assert cli.main(["report", "."]) == 0
    assert "<title>Benchmark moved<" in (folder / "report.html").read_text()


def test_duplicates_count_once_in_tables_and_figures(tmp_path, capsys):
    for _ in range(3):
        WriteResult(make_result(seed=0), tmp_path)
    WriteResult(make_result(seed=1), tmp_path)
    words = ["--latex", tmp_path / "t.tex", "--metrics", "path_length"]
    words += ["--columns", "n", "mean"]
    assert cli.main(["report", *map(str, [tmp_path, *words])]) == 0
    row = next(
        line
        for line in (tmp_path / "t.tex").read_text().splitlines()
        if line.startswith("path\\_length")
    )
    assert row.split("&")[1].strip() == "2"
    assert "2 runs (2 more are duplicates)" in capsys.readouterr().out
