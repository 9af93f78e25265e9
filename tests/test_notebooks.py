"""Notebooks run from start to end, and their outputs are those of today.

`python -m tests.test_notebooks` runs them and writes their outputs anew.
"""

from pathlib import Path
import re
import shutil
import tempfile

import nbclient
import nbformat
import pytest

NOTEBOOKS = sorted(
    (Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb")
)
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


def execute(notebook, folder):
    """Runs a notebook in a folder; what goes to stderr is no output."""
    client = nbclient.NotebookClient(
        notebook, timeout=300, resources={"metadata": {"path": folder}}
    )
    client.execute()
    for cell in code_cells(notebook):
        cell.outputs = [it for it in cell.outputs if it.get("name") != "stderr"]
        cell.metadata.pop("execution", None)


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def texts(notebook):
    """Returns the text that each cell shows, without that of pictures."""
    return [
        "".join(
            output.get("text") or output.data["text/plain"]
            for output in cell.outputs
            if "text" in output or "image/" not in str([*output.data])
        )
        for cell in code_cells(notebook)
    ]


def test_there_are_notebooks():
    assert NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_is_committed_with_its_outputs(path):
    """So that it can be read on the web; nothing tells of a machine."""
    cells = code_cells(nbformat.read(path, as_version=4))
    assert [it.execution_count for it in cells] == [*range(1, len(cells) + 1)]
    kinds = {it.output_type for cell in cells for it in cell.outputs}
    assert kinds <= {"stream", "display_data", "execute_result"}
    assert any(
        "image/png" in it.get("data", {}) for c in cells for it in c.outputs
    )
    assert not re.search(r"/(home|root|tmp|usr|Users)/", path.read_text())
    assert path.stat().st_size < 600_000


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_from_start_to_end(path, installed, tmp_path, monkeypatch):
    # The wheel, and no repository around.
    monkeypatch.setenv("PYTHONPATH", str(installed))
    shutil.copy(path, tmp_path)
    monkeypatch.setenv("DRAKE_DEPRECATION_RUNTIME_SEVERITY", "error")
    # Faster than real time: no one looks.
    monkeypatch.setenv("HUNAV_DRAKE_NOTEBOOK_TEST", "1")
    notebook = nbformat.read(path, as_version=4)
    kept = texts(notebook)
    where = "import hunav_drake; print(hunav_drake.__file__)"
    notebook.cells.append(nbformat.v4.new_code_cell(where))
    execute(notebook, tmp_path)
    *shown, used = texts(notebook)
    assert used.startswith(str(installed))
    if shutil.which("dot") is None:
        pytest.skip("it ran; its outputs are those of a machine with Graphviz")
    for one, other in zip(shown, kept, strict=True):
        assert re.sub(NUMBER, "#", one).split() == (
            re.sub(NUMBER, "#", other).split()
        )
        assert [*map(float, re.findall(NUMBER, one))] == pytest.approx(
            [*map(float, re.findall(NUMBER, other))], rel=0.01, abs=0.01
        )


def main():
    """Runs all notebooks, and writes their outputs into them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HUNAV_DRAKE_NOTEBOOK_TEST", "1")
        for path in NOTEBOOKS:
            notebook = nbformat.read(path, as_version=4)
            with tempfile.TemporaryDirectory() as folder:
                execute(notebook, folder)
            nbformat.write(notebook, path)
            print(path.name)


if __name__ == "__main__":
    main()
