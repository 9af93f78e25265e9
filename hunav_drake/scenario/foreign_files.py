"""Files of other programs that are read as scenarios."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from hunav_drake.scenario.building import Check
    from hunav_drake.scenario.error import Loc
    from hunav_drake.scenario.schema import Scenario
    from hunav_drake.scenario.yaml_document import YamlDocument


class ForeignScenario(Protocol):
    """The data of a scenario that another program has written.

    Attributes:
        name: The name of the file.
        data: The plain data of the scenario; overrides change it in place.
    """

    name: str
    data: dict[str, Any]

    def build(
        self, checks: Sequence[Check], locs: Mapping[Loc, str]
    ) -> Scenario:
        """Returns the scenario of the data.

        Args:
            checks: What is checked of it.
            locs: Which overrides have set what.

        Raises:
            ScenarioError: If it is not a scenario.
        """


# What reads a file, by the key at its top that tells its kind.
FOREIGN_FILES: dict[str, Callable[[YamlDocument], ForeignScenario]] = {}
