"""The gallery of scenarios, behaviors, activities and planners, in pictures."""

from collections.abc import Iterator
from pathlib import Path
import re

from hunav_drake.scenario import LoadScenario
from hunav_drake.scenarios import shipped_names
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.planning import PLANNERS

TREES = Path(__file__).parents[2] / "systems" / "behavior"

HEAD = """# Gallery

All that comes with the package, in pictures.
"""

# Kind, the page on it, and what stands in front of it.
PARTS = {
    "scenarios": "`hunav run NAME`, or `hunav edit NAME` to change one.",
    "behaviors": "How people react to a robot: `behavior: NAME`; see"
    " [behaviors](behaviors.md).",
    "activities": "What people do with places and with each other: `behavior:"
    " NAME`; see [activities](activities.md).",
    "planners": "The robot drives to the star, past people who wait in a line;"
    " numbers are seconds: `hunav run queue --planner NAME`; see"
    " [planners](planners.md).",
}


def gallery(docs: Path) -> str:
    """Returns the page, in Markdown.

    Args:
        docs: The folder of the docs, in which the pictures are.

    Raises:
        FileNotFoundError: If there is no picture of a choice.
    """
    lines = [HEAD]
    for kind, text in PARTS.items():
        lines += [f"## {kind.capitalize()}", "", text, ""]
        lines += ['<div class="cards" markdown="0">']
        for name, picture, told in _cards(kind):
            if not (docs / picture).exists():
                raise FileNotFoundError(
                    f"docs/{picture}: there is no picture of {name!r}; python"
                    f" docs/draw_gallery.py {name} draws it"
                )
            lines.append(
                f'<figure><img src="{picture}" alt="" loading="lazy">'
                f"<figcaption><code>{name}</code> {told}</figcaption></figure>"
            )
        lines += ["</div>", ""]
    return "\n".join(lines)


def _cards(kind: str) -> Iterator[tuple[str, str, str]]:
    """Gives name, picture and a sentence of each choice of a kind."""
    if kind == "scenarios":
        for name in shipped_names():
            scenario = LoadScenario(filename=name)
            yield name, f"gallery/scenarios/{name}.webp", scenario.description
    elif kind == "planners":
        for name, planner in PLANNERS.items():
            if name not in ("bridge", "external", "stand"):
                told = (planner.__doc__ or "").splitlines()[0]
                yield name, f"gallery/planners/{name}.webp", told
    elif kind == "behaviors":
        for name in BEHAVIORS:
            told = _first_comment(TREES / "trees" / f"{name}.xml")
            yield name, f"gallery/behaviors/{name}.webp", told
    else:
        for file in sorted((TREES / "activities").glob("*.xml")):
            name = file.stem
            yield name, f"activity_{name}.gif", _first_comment(file)


def _first_comment(file: Path) -> str:
    """Returns the comment at the head of a tree, on one line."""
    (told,) = re.findall(r"<!--(.*?)-->", file.read_text(), re.S)[:1]
    return " ".join(told.split())
