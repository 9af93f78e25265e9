"""The register of files of other programs that are read as scenarios."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from hunav_drake.scenario.building import Check
    from hunav_drake.scenario.error import Loc
    from hunav_drake.scenario.schema import Scenario
    from hunav_drake.scenario.yaml_document import YamlDocument


class ForeignScenario(Protocol):
    """The data of a scenario in a file of another program.

    Attributes:
        name: The name of the file.
        data: The plain data of the scenario; overrides change it in place.
    """

    name: str
    data: dict[str, Any]

    def build(
        self, checks: "Sequence[Check]", locs: "Mapping[Loc, str]"
    ) -> "Scenario":
        """Returns the checked scenario; `locs` has the applied overrides.

        Raises:
            ScenarioError: If the data have faults.
        """


# The readers of files, by the top-level key that identifies the format.
FOREIGN_FILES: dict[str, Callable[["YamlDocument"], ForeignScenario]] = {}
