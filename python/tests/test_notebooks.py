"""Each notebook runs from its first cell to its last, and says what it says it does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

FOLDER = ROOT / "python" / "notebooks"
#: What must be in the outputs of each: its answer, and one picture where it draws one.
ANSWERS = {
    "cart-from-csv": "Coulomb friction at rail",
    "mujoco-arm": "Delay at input m1",
    "own-function": "Gain error at input pump",
    "on-line-compensation": "(248, 412)",
}


def test_each_notebook_is_known_and_listed() -> None:
    found = {path.stem for path in FOLDER.glob("*.ipynb")}
    assert found == set(ANSWERS)
    guide = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    assert not [name for name in found if f"python/notebooks/{name}.ipynb" not in guide]


@pytest.mark.parametrize("name", ANSWERS)
def test_a_notebook_runs(name: str) -> None:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    if name == "mujoco-arm":
        pytest.importorskip("mujoco")
    path = FOLDER / f"{name}.ipynb"
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "stored without its outputs"
    client = nbclient.NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(FOLDER)}}
    )
    client.execute()
    outputs: list[Any] = [out for cell in notebook.cells for out in cell.get("outputs", ())]
    assert ANSWERS[name] in json.dumps(outputs), json.dumps(outputs)[:3000]
    assert any("image/png" in out.get("data", {}) for out in outputs)
