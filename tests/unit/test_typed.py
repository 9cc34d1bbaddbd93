"""Type annotations ship with the package."""

import tomllib
from importlib.resources import files
from pathlib import Path


def test_py_typed_is_in_the_package_and_in_the_wheel():
    assert (files("contbed") / "py.typed").is_file()
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))
    assert "py.typed" in project["tool"]["setuptools"]["package-data"]["contbed"]
