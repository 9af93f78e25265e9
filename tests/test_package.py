"""What the package says that it exports is there."""

import importlib
from types import FunctionType

import pytest

PACKAGES = [
    "hunav_drake",
    "hunav_drake.report.plots",
    "hunav_drake.report",
    "hunav_drake.runs",
    "hunav_drake.scenario",
    "hunav_drake.systems",
    "hunav_drake.systems.behavior",
    "hunav_drake.systems.crowd",
    "hunav_drake.systems.evaluation",
    "hunav_drake.systems.planning",
    "hunav_drake.systems.planning.costmap",
    "hunav_drake.systems.planning.dwb",
    "hunav_drake.systems.planning.global_planner",
    "hunav_drake.systems.planning.mppi",
    "hunav_drake.systems.planning.navigation",
    "hunav_drake.systems.planning.social",
    "hunav_drake.systems.robot",
    "hunav_drake.systems.scene",
]


@pytest.mark.parametrize("name", PACKAGES)
def test_every_export_is_there_and_documented(name):
    package = importlib.import_module(name)
    assert package.__doc__
    assert sorted(package.__all__) == sorted(set(package.__all__))
    assert set(package.__all__) <= set(dir(package))
    for export in package.__all__:
        value = getattr(package, export)
        if isinstance(value, type | FunctionType):
            assert value.__doc__, export


def test_what_is_not_exported_is_an_attribute_error():
    package = importlib.import_module("hunav_drake")
    with pytest.raises(AttributeError, match="RunTrail"):
        _ = package.RunTrail
