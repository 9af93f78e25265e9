from pathlib import Path
import shutil

import nbclient
import nbformat
import pytest

NOTEBOOKS = sorted(
    (Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb")
)


def test_there_are_notebooks():
    assert NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_is_committed_without_outputs(path):
    cells = nbformat.read(path, as_version=4).cells
    code = [cell for cell in cells if cell.cell_type == "code"]
    assert all(not cell.outputs for cell in code)
    assert all(cell.execution_count is None for cell in code)


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_from_start_to_end(path, installed, tmp_path, monkeypatch):
    # The wheel, and no repository around.
    monkeypatch.setenv("PYTHONPATH", str(installed))
    shutil.copy(path, tmp_path)
    monkeypatch.setenv("DRAKE_DEPRECATION_RUNTIME_SEVERITY", "error")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    # Faster than real time: no one looks.
    monkeypatch.setenv("HUNAV_DRAKE_NOTEBOOK_TEST", "1")
    notebook = nbformat.read(path, as_version=4)
    where = "import hunav_drake; print(hunav_drake.__file__)"
    notebook.cells.append(nbformat.v4.new_code_cell(where))
    client = nbclient.NotebookClient(
        notebook, timeout=300, resources={"metadata": {"path": tmp_path}}
    )
    client.execute()
    (used,) = notebook.cells[-1].outputs
    assert used.text.startswith(str(installed))
