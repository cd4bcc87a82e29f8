"""Notebooks run, and say what they are kept with. With `WRITE_NOTEBOOKS` set their output is replaced."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, List

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parent.parent / "examples").glob("*.ipynb"))


def texts(notebook: Any) -> List[str]:
    """What cells print and return, without pictures."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    plain = [output.get("text") or output.get("data", {}).get("text/plain", "") for output in outputs]
    return [text for text in plain if "Figure" not in text]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_says_what_it_is_kept_with(path: Path) -> None:
    kept = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    found = nbformat.from_dict(kept)  # type: ignore[no-untyped-call]
    resources = {"metadata": {"path": str(path.parent)}}
    NotebookClient(found, timeout=120, kernel_name="python3", coalesce_streams=True, resources=resources).execute()
    for cell in found.cells:
        # Times of the run.
        cell.metadata.pop("execution", None)
    if "WRITE_NOTEBOOKS" in os.environ:
        nbformat.write(found, path)  # type: ignore[no-untyped-call]
        return
    assert texts(found) == texts(kept)
    pictures = [o for cell in kept.cells for o in cell.get("outputs", []) if "image/png" in o.get("data", {})]
    assert len(pictures) == 1
