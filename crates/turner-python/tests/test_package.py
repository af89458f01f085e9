"""The package that is installed: its version, licences and command."""

import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

import pytest
import turner as tr

ROOT = Path(os.environ.get("TURNER_ROOT", Path(__file__).parents[3]))


@pytest.fixture
def package():
    try:
        found = importlib.metadata.distribution("turner")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("the module is not installed")
    return found


def test_its_version_is_that_of_the_renderer(package):
    assert package.version == tr.__version__
    told = subprocess.run([sys.executable, "-m", "turner", "--version"], check=True, capture_output=True, text=True).stdout
    assert package.version in told


def test_it_holds_the_licences(package):
    files = {Path(file).name: file.read_text(encoding="utf-8") for file in package.files if "licenses" in Path(file).parts}
    for name in ("LICENSE-APACHE", "LICENSE-MIT"):
        assert files[name] == (ROOT / name).read_text(encoding="utf-8")


def test_it_installs_the_command(package):
    assert [point.name for point in package.entry_points.select(group="console_scripts")] == ["turner"]
