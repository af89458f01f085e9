"""The notebook in a Jupyter kernel: what its cells show."""

import json
import os
from html.parser import HTMLParser
from pathlib import Path

import pytest

ROOT = Path(os.environ.get("TURNER_ROOT", Path(__file__).parents[3]))


class Frames(HTMLParser):
    """The pages inside a text's frames."""

    def __init__(self, text):
        super().__init__()
        self.pages = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "iframe":
            self.pages.append(dict(attrs)["srcdoc"])


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """The outputs of each cell with code, as lists of (data or text)."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    notebook = nbformat.read(ROOT / "examples/python/first-look.ipynb", as_version=4)
    folder = tmp_path_factory.mktemp("notebook")
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    nbformat.validate(notebook)
    return [cell["outputs"] for cell in notebook["cells"] if cell["cell_type"] == "code"]


def shown(outputs, kind):
    """The data of a media type among the outputs of a cell."""
    return [output["data"][kind] for output in outputs if kind in output.get("data", {})]


def test_every_cell_runs_and_pictures_show(outputs):
    kinds = [output["output_type"] for cell in outputs for output in cell]
    assert "error" not in kinds
    assert not outputs[0]
    # PNG files, base64.
    for cell in (outputs[1], outputs[4]):
        assert [png.startswith("iVBORw0KGgo") for png in shown(cell, "image/png")] == [True]
    numbers = shown(outputs[2], "text/plain")
    assert "'ball'" in numbers[0] and "'floor'" in numbers[0]


def test_the_bar_is_a_widget(outputs):
    pytest.importorskip("ipywidgets")
    assert "application/vnd.jupyter.widget-view+json" in json.dumps(outputs[1])
    assert "█" not in json.dumps(outputs[1], ensure_ascii=False)


def test_an_explanation_shows_its_page(outputs):
    (html,) = shown(outputs[3], "text/html")
    (page,) = Frames(html).pages
    assert page.startswith("<!DOCTYPE html>") or page.startswith("<!doctype html>")
    assert "<script" in page and page.rstrip().endswith("</html>")
    assert "<explanation of pixel (200, 150)" in shown(outputs[3], "text/plain")[0]
