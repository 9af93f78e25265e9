"""The schema of a search: which scenes are tried, for which failure."""

from collections.abc import Iterator
from dataclasses import field
import json
import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    StrictFloat,
    StrictStr,
    TypeAdapter,
    ValidationError,
)
from pydantic.dataclasses import dataclass
from pydantic_core import PydanticCustomError

from hunav_drake.scenario.building import (
    Places,
    document_faults,
    schema_findings,
)
from hunav_drake.scenario.error import ScenarioError
from hunav_drake.scenario.yaml_source import parse_yaml, read_yaml
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, Name, within
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.evaluation.robustness import robustness_of

# Values are rounded to this many digits after the point, to be readable; more
# where a range is narrower than this.
_DIGITS, _NARROW = 6, 1e-3


def _number(value: Any) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and math.isfinite(value)


def _check_range(value: Any) -> Any:
    pair = isinstance(value, list) and len(value) == 2
    if pair and all(map(_number, value)) and value[0] < value[1]:
        return value
    if isinstance(value, dict) and len(value) == 1:
        ((kind, items),) = value.items()
        if isinstance(items, list) and kind == "choices" and items:
            return value
        whole = isinstance(items, list) and len(items) == 2
        whole = whole and all(type(it) is int for it in items)
        if kind == "integers" and whole and items[0] <= items[1]:
            return value
    raise PydanticCustomError(
        "rule",
        "must be a range [low, high], {integers: [low, high]} or {choices:"
        " [...]}, got {value}",
        {"value": shown(value)},
    )


def _check_robustness(value: str) -> str:
    try:
        robustness_of(value)
    except ValueError as error:
        raise PydanticCustomError("rule", "{e}", {"e": str(error)}) from None
    return value


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Requirements:
    """What a scene must fulfil to be tried."""

    start_gap: Annotated[StrictFloat, within(0, 100, "m")] = 1.0
    """Smallest gap between a robot and a person listed under `humans` at the
    start, in meters."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SearchSpace:
    """The scenes that a search for failures may try."""

    scenario: Annotated[StrictStr, Field(min_length=1)]
    """Scenario that the scenes are made of: a shipped one by name, or a file,
    relative to the file of the search."""

    robustness: Annotated[Name, AfterValidator(_check_robustness)] = "collision"
    """Kind of failure: see `ROBUSTNESS`."""

    space: Annotated[
        dict[StrictStr, Annotated[Any, AfterValidator(_check_range)]],
        Field(min_length=1),
    ]
    """What differs between scenes: paths as for --set, each with a range of
    numbers [low, high], {integers: [low, high]} or {choices: [...]}."""

    require: Requirements = field(default_factory=Requirements)
    """What a scene must fulfil to be tried."""

    overrides: list[StrictStr] = field(default_factory=list)
    """Changes for all scenes, as for --set."""

    def values(self, point: Array) -> dict[str, Any]:
        """Returns the values of a point of the unit cube, by path."""
        found: dict[str, Any] = {}
        units = np.clip(point, 0.0, 1.0).tolist()
        for (path, item), u in zip(self.space.items(), units, strict=True):
            if isinstance(item, list):
                low, high = map(float, item)
                value = low + u * (high - low)
                narrow = min((high - low) / _NARROW, 1.0)
                digits = _DIGITS - math.floor(math.log10(narrow))
                found[path] = min(max(round(value, digits), low), high)
                continue
            ((kind, items),) = item.items()
            if kind == "choices":
                found[path] = items[min(int(u * len(items)), len(items) - 1)]
            else:
                low, high = items
                found[path] = min(low + int(u * (high - low + 1)), high)
        return found

    def ends(self) -> Iterator[tuple[str, list[Any]]]:
        """Yields each path with the ends of its range, or all its choices."""
        low, high = (self.values(np.full(len(self.space), u)) for u in (0, 1))
        for path, item in self.space.items():
            is_choice = isinstance(item, dict) and "choices" in item
            yield (
                path,
                item["choices"] if is_choice else [low[path], high[path]],
            )


def override_texts(values: dict[str, Any]) -> list[str]:
    """Returns values by path as texts for --set."""
    # (JSON is YAML.)
    return [f"{path}={json.dumps(it)}" for path, it in values.items()]


def LoadSearchSpace(
    *, filename: str | Path | None = None, data: str | None = None
) -> SearchSpace:
    """Loads the space of a search from a file or from text.

    A path of a scenario in a file starts from the folder of that file.

    Raises:
        ScenarioError: If it cannot be read or does not fit the schema; it lists
            all faults with their places. The scenario is read when it is
            searched.
        ValueError: If not exactly one of `filename` and `data` is given.
    """
    if (filename is None) == (data is None):
        raise ValueError(
            "LoadSearchSpace() takes exactly one of filename and data"
        )
    return read_space(filename, data or "")[0]


def read_space(
    filename: str | Path | None, data: str = ""
) -> tuple[SearchSpace, Places]:
    """Returns the space of a search, and the places of its parts."""
    document = (
        parse_yaml(data, name="data")
        if filename is None
        else read_yaml(filename)
    )
    faults = document_faults(document)
    if document.root is None or faults:
        raise ScenarioError(document.name, faults)
    plain = document.plain()
    places = Places(document)
    try:
        space = TypeAdapter(SearchSpace).validate_python(plain)
    except ValidationError as error:
        findings = schema_findings(error, plain, SearchSpace)
        raise ScenarioError(
            document.name, [places.fault(it, plain) for it in findings]
        ) from error
    if filename is not None:
        beside = Path(filename).resolve().parent / space.scenario
        if beside.is_file():
            space.scenario = str(beside)
    return space, places
