"""Pages on the public classes and functions, made from their docstrings."""

import ast
from pathlib import Path

import hunav_drake

# A page each: the module whose public names it shows, and its title.
BLOCKS = {
    "people": "People: configurations and populations",
    "crowd": "The crowd",
    "behavior": "Behavior trees",
    "world": "The world",
    "robot": "Robots",
    "planning": "Planners",
    "sensing": "Sensors",
    "evaluation": "Recording and metrics",
    "scene": "The scene",
}

LAYOUT = """# Vectors between systems

`from hunav_drake.systems.common.layout import ...`

::: hunav_drake.systems.common.layout
    options:
      show_root_heading: false
      show_root_toc_entry: false
"""


def api_pages() -> dict[str, str]:
    """Returns the pages in Markdown, by their names in the site."""
    package = Path(hunav_drake.__file__).parent
    told: set[str] = set()
    pages = {}
    for block, title in BLOCKS.items():
        module = f"hunav_drake.systems.{block}"
        exports = _exports(package / "systems" / block, module)
        pages[f"api/{block}.md"] = _page(module, exports, title, told)
    exports = _exports(package, "hunav_drake")
    page = _page("hunav_drake", exports, "Trials", told)
    return {"api/hunav_drake.md": page, **pages, "api/layout.md": LAYOUT}


def _page(
    module: str, exports: list[tuple[str, str]], title: str, told: set[str]
) -> str:
    """Returns a page on what a package exports and no page has told yet."""
    lines = [f"# {title}", "", f"`from {module} import ...`", ""]
    for source, name in exports:
        if name not in told:
            told.add(name)
            lines += [f"::: {source}.{name}", ""]
    return "\n".join(lines)


def _exports(folder: Path, module: str) -> list[tuple[str, str]]:
    """Returns the pairs (module that defines it, name) of what is exported.

    A package exports what its stub imports, or without one its file.
    """
    stub = folder / "__init__.pyi"
    file = stub if stub.exists() else folder / "__init__.py"
    found = []
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module != "typing":
            place = f"{module}.{node.module}" if node.level else node.module
            found += [(str(place), alias.name) for alias in node.names]
    return sorted(found, key=lambda pair: pair[1].lower())
