"""The map of the editor shows materials in the colors of the scene."""

from importlib import resources
import re

import pytest

from hunav_drake.systems.scene.palette import MATERIALS


def test_all_materials_of_furniture_have_their_colors():
    file = resources.files("hunav_drake.editor") / "static/map.css"
    rule = r'data-material="([^"]+)"\] \{ --made: #(\w+)'
    shown = dict(re.findall(rule, file.read_text(encoding="utf-8")))
    # (No furniture is made of wall.)
    assert shown.keys() == MATERIALS.keys() - {"wall"}
    for name, shade in shown.items():
        channels = [it / 255 for it in bytes.fromhex(shade)]
        color = MATERIALS[name]
        expected = [color.r(), color.g(), color.b()]
        assert channels == pytest.approx(expected, abs=0.06)
