"""The lowest versions of the libraries: each is declared once and installed by `make
test-floors`.
"""

import re
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from floors import floors  # noqa: E402


def test_every_dependency_has_a_lowest_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    count = len(project["dependencies"]) + len(project["optional-dependencies"]["test"])
    assert len(floors()) == count
    # below these contbed does not start, or meshes no geometry
    lowest = {"pydantic": (2, 11), "typer": (0, 19), "gmsh": (4, 12)}
    for item in floors():
        name, version = item.split("==")
        if name in lowest:
            assert tuple(map(int, version.split("."))) >= lowest[name], name


@pytest.mark.parametrize("item", floors(("test",)))
def test_what_is_installed_is_not_older(item):
    name, version = item.split("==")
    try:
        found = metadata.version(name)
    except metadata.PackageNotFoundError:
        pytest.skip(f"{name} is not installed")
    numbers = [
        tuple(int(part) for part in re.findall(r"\d+", text)[:3])
        for text in (found, version)
    ]
    assert numbers[0] >= numbers[1]
