"""The tests that CONTRIBUTING.md names exist."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_tests_that_are_named_exist():
    named = re.findall(
        r"`(tests/[\w/]+\.py)::(\w+)`",
        (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"),
    )
    assert len(named) >= 13
    for file, name in named:
        body = ast.parse((ROOT / file).read_text(encoding="utf-8")).body
        functions = [node.name for node in body if isinstance(node, ast.FunctionDef)]
        assert name in functions, f"{file}::{name}"


def test_modules_of_tests_have_names_of_their_own():
    """Folders of tests are no packages: a second module of a name is not imported."""
    names = [
        path.name
        for path in (ROOT / "tests").rglob("*.py")
        if path.name != "conftest.py"
    ]
    assert len(names) == len(set(names)), sorted(
        {name for name in names if names.count(name) > 1}
    )
