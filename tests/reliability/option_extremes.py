"""Sets each numeric option to its extremes, and runs a small trial with it.

`python -m tests.reliability.option_extremes [PREFIX]` does so for all options
whose place begins with the prefix, such as `planner[sfw]`, and lists what
hangs, fails after it was accepted, or takes too much memory.
"""

from collections.abc import Callable, Iterator
from functools import partial
import json
import os
import resource
import signal
import sys
import time
from typing import Any, NamedTuple
import warnings

from hunav_drake import LoadScenario, RunTrial, ScenarioError
from hunav_drake.scenario.json_schema import scenario_json_schema
from tests.memory import reset_peak_memory

# What a trial of half a second may take: seconds of computing, and bytes.
LIMIT = 20
MEMORY = 2 * 2**30

# What is tried, besides the bounds that the schema tells.
_VALUES = (1e-300, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9, 1e300)

_TOO_LONG = (signal.SIGXCPU, signal.SIGKILL, signal.SIGALRM)

# How long a trial is, is no extreme of it.
_SKIPPED = ("simulation.duration",)

_ROOM = {
    "simulation": {"duration": 0.5},
    "robot": {"start": [-2, -2, 0], "goal": [-2, 2, 0]},
    "humans": [
        {"name": "a", "pose": [-3, -1, 0], "goals": [[-3, 3]]},
        {"name": "b", "pose": [-1, 0, 0], "goals": [[-3, 0]], "group_id": 1},
    ],
    "world": {
        "walls": [{"type": "box", "center": [-4.5, 0], "size": [0.2, 9]}]
    },
}


class Case(NamedTuple):
    """A place of an option, a value, and the scenario that has it."""

    place: str
    value: Any
    data: dict[str, Any]


def cases(prefix: str = "") -> list[Case]:
    """Returns what is tried at all options whose place begins so."""
    schema = scenario_json_schema()
    walk = _Walk(schema["$defs"])
    found: list[Case] = []
    for key, part in schema["properties"].items():
        for place, value, wrapped in walk.leaves(part, key, lambda it: it):
            if place.startswith(prefix) and place not in _SKIPPED:
                found.append(Case(place, value, _with(key, wrapped)))
    return found


def _with(key: str, value: Any) -> dict[str, Any]:
    """Returns the room with another value of a part."""
    usual: Any = _ROOM.get(key)
    if isinstance(usual, dict) and isinstance(value, dict):
        value = {**usual, **value}
    if key == "humans":
        value = [{**usual[0], **value[0]}, usual[1]]
    return {**_ROOM, key: value}


class _Walk:
    """A walk through a JSON schema."""

    def __init__(self, definitions: dict[str, Any]) -> None:
        self._definitions = definitions

    def _resolved(self, schema: Any) -> Any:
        while "$ref" in schema:
            rest = {k: v for k, v in schema.items() if k != "$ref"}
            name = schema["$ref"].rpartition("/")[2]
            schema = {**self._definitions[name], **rest}
        return schema

    def leaves(
        self, schema: Any, place: str, wrap: Callable[[Any], Any]
    ) -> Iterator[tuple[str, Any, Any]]:
        """Yields the place, a value, and what holds it, for each number."""
        schema = self._resolved(schema)
        if place.count(".") + place.count("[") > 10:
            return
        for part in schema.get("oneOf", []) + schema.get("anyOf", []):
            yield from self.leaves(part, place, wrap)
        kind = schema.get("type")
        if kind in ("number", "integer"):
            for value in _extremes(schema):
                yield place, value, wrap(value)
        elif kind == "object":
            yield from self._of_object(schema, place, wrap)
        elif kind == "array":
            for i, part in enumerate(schema.get("prefixItems", [])):
                row = self.least(schema)
                yield from self.leaves(
                    part, f"{place}[{i}]", partial(_put, wrap, row, i)
                )
            if isinstance(schema.get("items"), dict):
                row = self.least({**schema, "default": None})
                row = row or [None]
                yield from self.leaves(
                    schema["items"], f"{place}[]", partial(_put, wrap, row, 0)
                )

    def _of_object(
        self, schema: Any, place: str, wrap: Callable[[Any], Any]
    ) -> Iterator[tuple[str, Any, Any]]:
        base = self.least({**schema, "default": None})
        for name in base.values():
            if isinstance(name, str) and name in str(schema["properties"]):
                place = f"{place}[{name}]"
                break
        for key, part in schema.get("properties", {}).items():
            yield from self.leaves(
                part, f"{place}.{key}", partial(_put, wrap, base, key)
            )

    def least(self, schema: Any) -> Any:
        """Returns something that a schema allows."""
        schema = self._resolved(schema)
        if schema.get("default") is not None:
            return schema["default"]
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return schema["enum"][0]
        for part in schema.get("oneOf", []) + schema.get("anyOf", []):
            return self.least(part)
        match schema.get("type"):
            case "number" | "integer":
                low = schema.get("minimum", schema.get("exclusiveMinimum", 0))
                return max(1, low)
            case "object":
                parts = schema.get("properties", {})
                wanted = {*schema.get("required", [])}
                wanted |= {key for key in parts if "const" in parts[key]}
                return {
                    key: self.least(parts[key])
                    for key in parts
                    if key in wanted
                }
            case "array":
                row = [self.least(it) for it in schema.get("prefixItems", [])]
                for i in range(len(row), schema.get("minItems", 0)):
                    item = self.least(schema["items"])
                    if item == [1, 1]:
                        # Corners of a polygon.
                        item = [1 + i % 2, 1 + i // 2]
                    row.append(item)
                return row
        return "a" if schema.get("type") == "string" else None


def _put(wrap: Callable[[Any], Any], base: Any, key: Any, value: Any) -> Any:
    """Wraps a copy of a list or a mapping with another value."""
    copy = base.copy()
    copy[key] = value
    return wrap(copy)


def _extremes(schema: Any) -> list[Any]:
    """Returns the values of a number that its schema allows, but extreme."""
    low = schema.get("minimum", schema.get("exclusiveMinimum", -1e300))
    high = schema.get("maximum", schema.get("exclusiveMaximum", 1e300))
    is_open = "minimum" not in schema
    values = [low, high, *_VALUES, *(-it for it in _VALUES)]
    if schema["type"] == "integer":
        values = [int(it) for it in values if abs(it) <= 1e9]
    return list(
        dict.fromkeys(
            it
            for it in values
            if (low < it if is_open else low <= it) and it <= high
        )
    )


def outcome(case: Case) -> str:
    """Runs a case in a child process.

    Returns:
        Nothing if all is well; "refused: ...", if the scenario is; else what
        went wrong.
    """
    reading, writing = os.pipe()
    before = reset_peak_memory()
    child = os.fork()
    if child == 0:
        os.close(reading)
        os.write(writing, _try(case).encode()[:4000])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as file:
        told = file.read()
    _, status, usage = os.wait4(child, 0)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) in _TOO_LONG:
        return f"hangs: not over after {LIMIT} s of computing"
    if status:
        return f"dies: status {status}"
    taken = usage.ru_maxrss * 1024 - before
    if taken > MEMORY and not told.startswith("refused"):
        return f"takes {taken / 2**30:.1f} GB"
    return told


def _try(case: Case) -> str:
    """Returns what comes of a case, in this process."""
    with open("/proc/self/statm") as file:
        size = int(file.read().split()[0]) * resource.getpagesize()
    limit = size + 2 * MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
    # What waits without computing is hung as well.
    signal.alarm(10 * LIMIT)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            scenario = LoadScenario(data=json.dumps(case.data))
        except ScenarioError as error:
            return f"refused: {error.faults[0]}"
        except BaseException as error:
            return f"fails to load: {type(error).__name__}: {error}"
        try:
            RunTrial(scenario)
        except BaseException as error:
            return f"fails: {type(error).__name__}: {error}"
    for warning in told:
        if issubclass(warning.category, RuntimeWarning):
            return f"warns: {warning.message} ({warning.filename})"
    return ""


def main(prefixes: list[str]) -> int:
    """Prints what goes wrong; returns 1 if anything does."""
    # Compiled once for all children.
    RunTrial(LoadScenario(data=json.dumps(_ROOM)))
    found = [it for prefix in prefixes or [""] for it in cases(prefix)]
    counts = {"refused": 0, "run": 0, "wrong": 0}
    for case in found:
        start = time.monotonic()
        told = outcome(case)
        if told.startswith("hangs"):
            # It may have compiled kernels, which are kept now.
            told = outcome(case)
        taken = time.monotonic() - start
        if "-v" in sys.argv:
            print(f"{case.place} = {case.value}: {taken:.1f} s", flush=True)
        kind = "refused" if told.startswith("refused") else "wrong"
        counts[kind if told else "run"] += 1
        if told and (kind == "wrong" or "-v" in sys.argv):
            print(f"{case.place} = {case.value}: {told}", flush=True)
    print(counts, flush=True)
    return int(counts["wrong"] > 0)


if __name__ == "__main__":
    raise SystemExit(main([it for it in sys.argv[1:] if it != "-v"]))
