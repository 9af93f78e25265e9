"""What README and docs show runs as it is printed."""

from pathlib import Path
import re
import shlex
import shutil

import matplotlib as mpl
import numpy as np
import pytest

from hunav_drake import (
    LoadScenario,
    LoadSearchSpace,
    ReadRecording,
    Tracks,
    WriteBag,
    WriteTracks,
)
from hunav_drake.commands import cli
from hunav_drake.runs import LoadSuite
from hunav_drake.scenario.generate.kind import KINDS
from hunav_drake.systems.behavior.nodes import registry as nodes
from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.evaluation import METRICS, ROBUSTNESS
from hunav_drake.systems.people.tracks import Track
from hunav_drake.systems.planning import PLANNERS
from hunav_drake.systems.robot import ROBOTS
from tests.agents import AGENTS
from tests.maps import write_map
from tests.systems.robot.crate import FOOTPRINT

# What the pages call a rack, and a robot.
RACK = """<sdf version="1.9"><model name="rack">
<link name="rack"><collision name="rack"><pose>0 0 0.5 0 0 0</pose>
<geometry><box><size>0.5 1 1</size></box></geometry></collision></link>
</model></sdf>"""
HALL = f"""<sdf version="1.6"><world name="hall"><model name="rack">
<static>1</static><pose>2 5 0 0 0 0</pose>{RACK.split('name="rack">', 1)[1]}
""".replace("</sdf>", "</world></sdf>")
ROBOT = (
    FOOTPRINT.replace("left_joint", "wheel_left_joint")
    .replace("right_joint", "wheel_right_joint")
    .replace("0.15 -0.04", "0.2 -0.02")
    .replace('radius="0.08"', 'radius="0.1"')
)
ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def snippets(page, language):
    """Returns the blocks of a page in a language, in their order."""
    return re.findall(
        rf"^```{language}\n(.*?)^```", page.read_text(), re.M | re.S
    )


# Their Python is run by test_docs.py, which looks at what comes of it.
LOOKED_AT = {"own_planner", "robots", "sensors"}
# These start other processes.
SLOW = {"benchmark"}


def pages_with(language):
    return [
        pytest.param(
            page,
            id=page.stem,
            marks=[pytest.mark.slow] if page.stem in SLOW else [],
        )
        for page in PAGES
        if snippets(page, language)
        and not (language == "python" and page.stem in LOOKED_AT)
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_code_of_a_page_stands_in_blocks_of_a_known_language(page):
    """So that none is left out here."""
    text = page.read_text()
    languages = re.findall(r"^```(.*)\n(?:[^`]|`(?!``))*^```$", text, re.M)
    assert set(languages) <= {"python", "yaml", "xml", "sh", "text"}
    if page.stem not in ("standard_results", "generalize_results"):
        # Those pages are written by the commands that they show.
        rest = re.sub(r"^```.*\n(?:.*\n)*?```$", "", text, flags=re.M)
        assert not re.findall(r"\n\n    .*", rest)
    for line in "\n".join(snippets(page, "sh")).splitlines():
        words = shlex.split(line, comments=True)
        if not words:
            continue
        assert words[0] in PROGRAMS, line
        if words[0] == "make":
            assert re.search(rf"^{words[1]}:", MAKEFILE, re.M), line


PROGRAMS = {"hunav", "make", "source", "python3", ".venv/bin/pip", "pip"}
PROGRAMS |= {"uv", "conda", "docker"}
MAKEFILE = (ROOT / "Makefile").read_text()


@pytest.fixture(autouse=True)
def registers_as_before(monkeypatch, tmp_path):
    """What snippets register, and write, is not there for other tests."""
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    for registry in (PLANNERS, MOTION_MODELS, ROBOTS, KINDS):
        monkeypatch.setattr(registry, "_choices", dict(registry))
    plain = (METRICS, ROBUSTNESS, nodes._TYPES)
    before = [dict(register) for register in plain]
    yield
    for register, was in zip(plain, before, strict=True):
        register.clear()
        register.update(was)


def write_tracks(path):
    """Writes a few people who cross each other, as a recording of 12 s."""
    times = np.arange(30) * 0.4
    way = np.column_stack([1.2 * times - 7, 0 * times])
    people = [
        Track(i, times, way @ [[c, s], [-s, c]] + [0, 0.3 * i])
        for i, (c, s) in enumerate([(1, 0), (-1, 0), (0, 1), (0.6, 0.8)])
    ]
    WriteTracks(Tracks(tuple(people)), path, "ucy")


@pytest.mark.slow
@pytest.mark.parametrize("page", pages_with("python"))
def test_the_python_of_a_page_runs(page):
    """All blocks in one go, as someone who reads the page types them."""
    write_tracks("zara01.txt")
    made = {"__name__": "snippets"}
    for block in snippets(page, "python"):
        exec(compile(block, page.name, "exec"), made)
    for name, function in made.items():
        if name.startswith("test_"):
            # Those that are parametrized are, by a seed.
            marks = getattr(function, "pytestmark", [])
            function(*(0 for _ in marks))


@pytest.mark.slow
@pytest.mark.parametrize("page", pages_with("yaml"))
def test_the_yaml_of_a_page_is_a_scenario_or_a_suite(page, tmp_path):
    work = tmp_path / "mine"
    (work / "models").mkdir(parents=True)
    (work / "models" / "my_robot.urdf").write_text(ROBOT)
    shutil.copy(ROOT / "tests/data/car.urdf", work / "models" / "my_car.urdf")
    (tmp_path / "my_robot").mkdir()
    (tmp_path / "my_robot" / "package.xml").write_text("<package/>")
    (work / "rack.sdf").write_text(RACK)
    (work / "hall.world").write_text(HALL)
    write_map(work, ["####", "#..#", "####"], name="house", origin=[9, 9, 0])
    write_tracks(work / "zara01.txt")
    for block in snippets(page, "yaml"):
        if re.search(r"^scenarios:", block, re.M):
            text = re.sub(r"[\w/]+\.yaml", "cafe", block)
            assert LoadSuite(data=text).planners
        elif re.search(r"^space:", block, re.M):
            LoadSearchSpace(data=block)
        else:
            (work / "my.yaml").write_text(block)
            LoadScenario(filename=work / "my.yaml")


@pytest.mark.parametrize("page", pages_with("xml"))
def test_the_xml_of_a_page_is_a_behavior(page, tmp_path):
    for block in snippets(page, "xml"):
        (tmp_path / "mine.xml").write_text(block)
        assert cli.main(["tree", "check", "mine.xml"]) == 0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the files that the pages speak of."""
    folder = tmp_path_factory.mktemp("user")
    shutil.copy(ROOT / "scenarios" / "cafe.yaml", folder / "my.yaml")
    (folder / "agents.yaml").write_text(AGENTS)
    (folder / "hall.world").write_text(HALL)
    for page, name in (
        ("own_metric", "my_metrics.py"),
        ("own_motion_model", "my_model.py"),
        ("own_planner", "my_planners.py"),
    ):
        code = snippets(ROOT / "docs" / f"{page}.md", "python")[0]
        # The class, without the trial that the page runs of it.
        (folder / name).write_text(
            re.split(r"^scenario|^result", code, flags=re.M)[0]
        )
    tree = re.search(
        r'"""\n(.*?)"""', (ROOT / "docs/own_behavior.md").read_text(), re.S
    )
    (folder / "mine.xml").write_text(tree[1])
    for name in ("zara01", "eth", "students003"):
        write_tracks(folder / f"{name}.txt")
    rows = [f"1 {k} {10 * k} 50 160" for k in range(60)]
    (folder / "corridor.txt").write_text("\n".join(rows))
    assert cli.main(["run", "passing", "--out", f"{folder}/results"]) == 0
    shutil.copytree(folder / "results", folder / "out" / "social_layer")
    (run,) = (folder / "results" / "runs").iterdir()
    shutil.copy(run / "recording.npz", folder / "recording.npz")
    WriteBag(ReadRecording(run / "recording.npz"), folder / "experiment.mcap")
    return folder


def command_lines(inline=False):
    """Yields each command that a page shows once, also within sentences."""
    seen = set()
    for page in PAGES:
        text = page.read_text()
        lines = re.findall(r"^(?:    )?(hunav [^\n]*)", text, re.M)
        if inline:
            lines += re.findall(r"`(hunav [a-z][^`]*)`", text)
        for line in lines:
            words = shlex.split(line, comments=True)[1:]
            if words and tuple(words) not in seen:
                seen.add(tuple(words))
                yield pytest.param(words, id=f"{page.stem}: {' '.join(words)}")


@pytest.mark.parametrize("words", list(command_lines(inline=True)))
def test_a_command_of_a_page_is_understood(words):
    # Named in a sentence, it may lack what it needs.
    assert any(
        parses([*words, *more])
        for more in ([], ["x"], ["x", "x"], ["x", "-o", "x"])
    )


def parses(words):
    try:
        return callable(cli._make_parser().parse_args(words).function)
    except SystemExit as end:
        # Help and version are shown, and that is all.
        return end.code == 0


# These take long, or a browser, or a network; they have tests of their own.
LONG = {"bench", "validate", "edit", "doctor", "render", "falsify", "risk"}
LONG |= {"bridge"}


@pytest.mark.slow
@pytest.mark.parametrize("words", list(command_lines()))
def test_a_command_of_a_page_runs(words, folder, monkeypatch, tmp_path):
    is_long = words[0] in LONG and "--at" not in words
    if is_long or {"--meshcat", "--foxglove", "--address"} & {*words}:
        pytest.skip("takes long, a browser or a cluster: tested elsewhere")
    work = tmp_path / "work"
    shutil.copytree(folder, work)
    monkeypatch.chdir(work)
    if words[0] == "import":
        # It makes the file that the other commands read.
        (work / "my.yaml").unlink()
    assert cli.main(words) in {0, 1}
