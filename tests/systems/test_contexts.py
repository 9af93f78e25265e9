"""Systems take their own Context alone, as Drake's do."""

import inspect

import pytest

from hunav_drake import MakeTrialDiagram
from tests.hunav_drake.test_branches import PAIR, stage


def methods(system):
    """Yields the names of methods of ours that take a Context first."""
    for name, method in inspect.getmembers(type(system), inspect.isfunction):
        words = list(inspect.signature(method).parameters)
        if words[1:2] == ["context"] and not name.startswith("_"):
            yield name


@pytest.mark.parametrize("planner", ["pursuit", "external"])
def test_the_context_of_another_system_is_refused(planner):
    diagram = MakeTrialDiagram(stage(PAIR, planner=planner))
    context = diagram.CreateDefaultContext()
    people = diagram.GetSubsystemByName("humans")
    found = set()
    for system in (*diagram.GetSystems(), *people.GetSystems()):
        for name in methods(system):
            method = getattr(system, name)
            rest = [None] * (len(inspect.signature(method).parameters) - 1)
            with pytest.raises(RuntimeError, match="root Diagram's Context"):
                method(context, *rest)
            found.add(name)
    assert found >= {"SetStates", "SetPose", "GetMemory", "GetRecording"}
