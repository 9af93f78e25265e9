"""Draws `diagram.svg`, the diagram of a trial as Drake sees it.

    python docs/draw_diagram.py

It needs Graphviz.
"""

from pathlib import Path
import re
import subprocess

from hunav_drake import LoadScenario, MakeTrialDiagram


def describe_trial() -> str:
    """Returns the diagram of a trial in the language of Graphviz."""
    diagram = MakeTrialDiagram(LoadScenario(filename="passing"))
    text = diagram.GetGraphvizString(max_depth=1)
    # Classes without their modules.
    return re.sub(r"hunav_drake\.[\w.]*\.(\w+)", r"\1", text)


if __name__ == "__main__":
    picture = Path(__file__).with_name("diagram.svg")
    subprocess.run(
        ["dot", "-Tsvg", "-Gdpi=60", "-o", picture],
        input=describe_trial(),
        text=True,
        check=True,
    )
    print(f"Wrote {picture}")
