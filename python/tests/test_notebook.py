"""The notebook of the documentation runs, and its outputs are those that are committed."""

from pathlib import Path

import nbformat
from conftest import FIXTURES
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).resolve().parents[1] / "examples" / "recorded-to-diagnosed.ipynb"


def _verdict(code) -> str:
    """Verdict, cause and figures of the diagnosis, as the notebook shows them."""
    shown = [output.data["text/plain"] for cell in code for output in cell.outputs if "data" in output]
    [said] = [text for text in shown if text.startswith("Diagnosis(")]
    return said


def test_the_notebook_goes_from_a_recorded_log_to_a_diagnosis(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(code) == 10
    committed = _verdict(code)
    kinds = [list(output.data) for cell in code for output in cell.outputs if "data" in output]
    assert sum("image/png" in kind for kind in kinds) == 2
    (tmp_path / "fixtures").symlink_to(FIXTURES)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = str([cell.outputs for cell in code])
    assert "image/png" in shown and "text/html" in shown
    assert _verdict(code) == committed
    # What the text says: the friction that the motor's file lacks, 0.02 N m, within its interval.
    said = "".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    assert "Coulomb friction" in said and "Cause: Coulomb friction" in committed
    friction = committed.split("torque_nm ")[1].split(" N m")[0]
    low, high = committed.split("(95 % interval ")[1].split(")")[0].split(" to ")
    assert float(low) <= 0.02 <= float(high) and f"{friction} N m" in said
