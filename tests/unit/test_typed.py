"""Type annotations ship with the package."""

import tomllib
from importlib.resources import files
from pathlib import Path


def test_py_typed_is_in_the_package_and_in_the_wheel():
    assert (files("contbed") / "py.typed").is_file()
    project = tomllib.loads(
        (Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8")
    )
    shipped = project["tool"]["setuptools"]["package-data"]["contbed"]
    assert "py.typed" in shipped and "many/validate/cases/*/*" in shipped


def test_the_package_shows_what_users_need():
    """`dir(contbed)` has the functions and classes of the README, all errors, and
    nothing of how they are found.
    """
    import contbed
    from contbed import errors

    kinds = {name for name in vars(errors) if name.endswith("Error")}
    assert all(getattr(contbed, name) is getattr(errors, name) for name in kinds)
    assert set(dir(contbed)) == kinds | {
        "Plan",
        "Result",
        "Scene",
        "gradient",
        "load",
        "plan",
        "run",
        "__version__",
    }
