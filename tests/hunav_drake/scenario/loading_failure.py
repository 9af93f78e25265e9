"""What loading a faulty scenario raises."""

import pytest

from hunav_drake import LoadScenario, ScenarioError


def failure(**kwargs) -> ScenarioError:
    with pytest.raises(ScenarioError) as info:
        LoadScenario(**kwargs)
    return info.value
