"""The guides and examples run."""

import json
import os
import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(os.environ.get("TURNER_ROOT", Path(__file__).parents[3]))


def run(text, name, folder, monkeypatch):
    """Runs a program in an empty folder, as a file."""
    (folder / "page.py").write_text(text, encoding="utf-8")
    monkeypatch.chdir(folder)
    return runpy.run_path(str(folder / "page.py"), run_name=name)


@pytest.mark.parametrize("page", ["python", "datasets", "cluster"])
@pytest.mark.filterwarnings("ignore")
def test_the_programs_of_guides_run(page, tmp_path, monkeypatch):
    if page == "cluster":
        pytest.importorskip("distributed")
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S)
    assert blocks
    run("\n".join(blocks), "__main__", tmp_path, monkeypatch)


@pytest.mark.filterwarnings("ignore")
def test_the_notebook_runs(tmp_path, monkeypatch):
    cells = json.loads((ROOT / "examples/python/first-look.ipynb").read_text(encoding="utf-8"))["cells"]
    text = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    run(text, "notebook", tmp_path, monkeypatch)


def test_the_examples_run(tmp_path):
    pictures = runpy.run_path(str(ROOT / "examples/python/pictures.py"))
    assert pictures["room"]().objects.names() == ["ball", "mirror", "floor"]
    views = runpy.run_path(str(ROOT / "examples/python/torch_dataset.py"))["views"]
    item = views(ROOT / "scenes/guides/solids.toml", 2)[0]
    assert item["image"].shape == (120, 160, 4) and item["normal"].shape == (120, 160, 3)
