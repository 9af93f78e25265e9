"""What the documentation shows is what there is."""

from pathlib import Path
import re

from hunav_drake import LoadScenario, MakeTrialDiagram
from tests import architecture

DOCS = Path(__file__).resolve().parents[1] / "docs"


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
