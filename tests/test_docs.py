"""What the documentation shows is what there is."""

from pathlib import Path
import re
import textwrap

import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram
from hunav_drake.scenario import draw_people
from tests import architecture

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


def readme_code():
    """Yields the sections of the README with the Python code in each."""
    for section in (ROOT / "README.md").read_text().split("\n## ")[1:]:
        title, _, text = section.partition("\n")
        blocks = re.findall(r"(?:^    .*\n|^\n)+", text, re.M)
        code = [b for b in blocks if "import " in b and "    hunav " not in b]
        if code:
            yield pytest.param(textwrap.dedent("".join(code)), id=title)


@pytest.mark.parametrize("code", list(readme_code()))
def test_the_code_of_the_readme_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {"__name__": "readme"})


def test_the_population_of_the_readme_can_be_drawn():
    text = (ROOT / "README.md").read_text()
    (block,) = re.findall(r"^    population:\n(?:     .*\n)+", text, re.M)
    scenario = LoadScenario(data=textwrap.dedent(block))
    assert len(draw_people(scenario)) == 20


def test_the_drawing_of_the_diagram_is_up_to_date():
    """`python docs/draw_diagram.py` draws it anew."""
    diagram = MakeTrialDiagram(LoadScenario(filename="passing"))
    drawing = (DOCS / "diagram.svg").read_text()
    drawn = set(re.findall(r">([^<]+)</text>", drawing))
    for system in diagram.GetSystems():
        assert f"name={system.get_name()}" in drawn
    exported = {
        diagram.get_output_port(i).get_name()
        for i in range(diagram.num_output_ports())
    }
    assert exported <= drawn


def test_every_room_is_described():
    text = (DOCS / "architecture.md").read_text()
    rooms = {
        folder
        for folder in architecture.files_per_folder()
        if folder.count("/") == 1
    }
    for room in rooms:
        assert room in text or f"`{room.split('/')[1]}/`" in text, room
