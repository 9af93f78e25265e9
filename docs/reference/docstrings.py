"""Docstrings in Drake's reStructuredText, as Markdown for the API pages."""

import re
from typing import Any

import griffe
import yaml

_SYSTEM = re.compile(r"^\.\. pydrake_system::\n\n((?: +.*\n|\n)+)", re.M)


class DocstringsAsMarkdown(griffe.Extension):
    """Draws blocks of ports, and ends lines before code in one colon."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrites the docstring of an object."""
        if obj.docstring:
            text = _SYSTEM.sub(_block, obj.docstring.value + "\n")
            obj.docstring.value = re.sub(r"::$", ":", text, flags=re.M).strip()


def _block(found: re.Match[str]) -> str:
    """Returns a system with its input ports and its output ports in HTML."""
    system = yaml.safe_load(found[1])
    sides = (
        "".join(f"<span>{port}</span>" for port in system.get(key) or [])
        for key in ("input_ports", "output_ports")
    )
    inputs, outputs = sides
    return (
        '<div class="system" role="img" aria-label="Ports of'
        f' {system["name"]}"><div class="inputs">{inputs}</div>'
        f"<div>{system['name']}</div>"
        f'<div class="outputs">{outputs}</div></div>\n\n'
    )
