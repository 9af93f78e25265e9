"""The editor in a notebook: the function that makes its widget."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hunav_drake.scenario.schema import Scenario

if TYPE_CHECKING:
    from hunav_drake.editor.widget import ScenarioEditor


def EditScenario(
    scenario: Scenario | str | Path | None = None,
    *,
    imports: Sequence[str] = (),
    height: int = 640,
) -> "ScenarioEditor":
    """Shows a scenario in a notebook, to be edited with the mouse.

    The widget holds the scenario as it is by then::

        editor = EditScenario("cafe")
        editor                        # shows it
        RunTrial(editor.scenario)     # in a later cell

    Nothing is written but by its `save`, or by Save in the editor.

    Args:
        scenario: A Scenario, which stays as it is; the name of a shipped one;
            a file, which need not exist yet; or the text of a file. By
            default, an empty scenario.
        imports: Modules, or paths of Python files, that register parts of
            one's own, for the process that runs trials.
        height: The height of the widget, in pixels.

    Raises:
        ImportError: If anywidget is not installed.
        ValueError: If the file cannot be read.
    """
    try:
        from hunav_drake.editor.widget import ScenarioEditor
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] not in ("anywidget", "traitlets"):
            raise
        raise ImportError(
            "EditScenario needs anywidget: pip install 'hunav_drake[editor]'"
        ) from None
    return ScenarioEditor(scenario, imports=imports, height=height)
