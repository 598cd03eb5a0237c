"""The notebook of the documentation runs."""

from pathlib import Path

import nbformat
from conftest import FIXTURES
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).resolve().parents[1] / "examples" / "recorded-to-diagnosed.ipynb"


def test_the_notebook_goes_from_a_recorded_log_to_a_diagnosis(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(code) == 10
    assert not any(cell.outputs for cell in code), "outputs are made anew, never committed"
    (tmp_path / "fixtures").symlink_to(FIXTURES)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = str([cell.outputs for cell in code])
    assert "coulomb_friction" in shown
    assert "image/png" in shown and "text/html" in shown
