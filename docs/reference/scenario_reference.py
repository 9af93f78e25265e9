"""The page on the keys of scenario files, made from their JSON schema."""

import json
from typing import Any

from hunav_drake.scenario.json_schema import scenario_json_schema

Schema = dict[str, Any]

HEAD = """# Keys of scenario files

A scenario is YAML. These are its keys, what they mean, their ranges and their
defaults, as `hunav schema` has them. Lengths are in meters, times in seconds,
angles in radians. A key that is left out has its default; an unknown key is an
error. A choice (planner, model, robot, sensor, wall) is given by its name
alone, or with its keys beside: `planner: {type: dwb, cycle_limit: 2.0}`.
"""


def scenario_reference() -> str:
    """Returns the page, in Markdown."""
    schema = scenario_json_schema()
    page = _Page(schema.get("$defs", {}))
    page.add("Scenario", schema, "A scenario")
    return HEAD + "\n".join(page.lines) + "\n"


class _Page:
    """Sections, one for each class, in the order in which keys name them."""

    def __init__(self, classes: dict[str, Schema]):
        self.lines: list[str] = []
        self._classes = classes
        self._told: set[str] = set()

    def add(self, name: str, schema: Schema, title: str) -> None:
        """Adds a section on a class, and those on the classes it names."""
        if name in self._told:
            return
        self._told.add(name)
        self.lines += ["", f"## {title} {{ #{name} }}", ""]
        if text := schema.get("description"):
            self.lines += [_first_paragraph(text), ""]
        self.lines += ["| key | meaning | values | default |"]
        self.lines += ["| --- | --- | --- | --- |"]
        required = schema.get("required", [])
        later: list[tuple[str, Schema, str]] = []
        for key, part in schema.get("properties", {}).items():
            values, named = self._values(part, key)
            later += named
            default = "needed" if key in required else _default(part)
            meaning = part.get("description", "")
            if not meaning and len(named) == 1:
                meaning = _first_paragraph(named[0][1].get("description", ""))
            meaning = _cell(meaning)
            self.lines.append(f"| `{key}` | {meaning} | {values} | {default} |")
        for named_class in later:
            self.add(*named_class)

    def _values(
        self, part: Schema, key: str
    ) -> tuple[str, list[tuple[str, Schema, str]]]:
        """Returns what a value may be, and the classes that it names."""
        if "$ref" in part:
            name = part["$ref"].rsplit("/", 1)[1]
            schema = self._classes[name]
            return f"[{name}](#{name})", [(name, schema, name)]
        for union in ("oneOf", "anyOf"):
            if union in part:
                texts, named = [], []
                for option in part[union]:
                    text, classes = self._option(option, key)
                    texts.append(text)
                    named += classes
                return ", or ".join(dict.fromkeys(filter(None, texts))), named
        if part.get("type") == "array" and isinstance(part.get("items"), dict):
            text, named = self._values(part["items"], key)
            return f"list of {text}", named
        return _simple(part), []

    def _option(
        self, option: Schema, key: str
    ) -> tuple[str, list[tuple[str, Schema, str]]]:
        """Returns one member of a choice, which may be a class with a name."""
        choice = option.get("properties", {}).get("type", {}).get("const")
        if choice is not None:
            name = f"{key}-{choice}"
            title = f"`{key}: {{type: {choice}}}`"
            return f"[`{choice}`](#{name})", [(name, option, title)]
        if "enum" in option:
            # The names alone, of the choices that stand beside.
            return "", []
        return self._values(option, key)


def _simple(part: Schema) -> str:
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    if "const" in part:
        return f"`{part['const']}`"
    kind = part.get("type", "")
    if kind == "array":
        items = part.get("prefixItems", [])
        labels = part.get("x-labels")
        if labels:
            return f"[{', '.join(labels)}]"
        return f"{len(items)} numbers" if items else "list"
    words = {
        "boolean": "true, false",
        "string": "text",
        "null": "none",
        "integer": "whole number",
        "object": "mapping",
    }
    return words.get(kind, kind) + _range(part)


def _range(part: Schema) -> str:
    unit = part.get("x-unit", "")
    unit = f" {unit}" if unit else ""
    low = part.get("minimum", part.get("exclusiveMinimum", part.get("ge")))
    high = part.get("maximum", part.get("exclusiveMaximum", part.get("le")))
    if low is None and high is None:
        return unit
    more = "> " if "exclusiveMinimum" in part else ">= "
    if high is None:
        return f", {more}{low:g}{unit}"
    if low is None:
        return f", <= {high:g}{unit}"
    bracket = "(" if "exclusiveMinimum" in part else "["
    return f" in {bracket}{low:g}, {high:g}]{unit}"


def _default(part: Schema) -> str:
    if "default" not in part:
        return ""
    value = part["default"]
    if value is None or value in ("", [], {}):
        return ""
    text = json.dumps(value, ensure_ascii=False)
    return f"`{text}`" if len(text) <= 60 else "see there"


def _first_paragraph(text: str) -> str:
    return " ".join(text.split("\n\n")[0].split())


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
