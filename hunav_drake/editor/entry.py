"""The function that opens the editor in a notebook."""

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
    """Shows a scenario in a notebook, to edit it with the mouse.

    The widget has the current scenario::

        editor = EditScenario("cafe")
        editor                        # shows it
        RunTrial(editor.scenario)     # in a later cell

    Only its `save`, and Save in the editor, write a file.

    Args:
        scenario: A Scenario, which is not changed; the name of a shipped one;
            a file, which need not exist yet; or the text of a file. By
            default, an empty scenario.
        imports: Modules, or paths of Python files, that register user parts,
            for the process that runs trials.
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
