"""Examples in docstrings print what they claim; those of closures are run with their
sheets.
"""

import doctest
from importlib import import_module
from pathlib import Path

import pytest

import contbed

PACKAGE = Path(contbed.__file__).parent
WITH_EXAMPLES = sorted(
    ".".join(("contbed", *path.relative_to(PACKAGE).with_suffix("").parts))
    for path in PACKAGE.rglob("*.py")
    if path.parent.name != "closures"
    and path.name != "__init__.py"
    and ">>> " in path.read_text(encoding="utf-8")
)


def test_the_functions_that_users_call_have_examples():
    named = {contbed._HOMES[name] for name in ("load", "plan", "run", "gradient")}
    assert {f"contbed.{module}" for module in named} <= set(WITH_EXAMPLES)


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_examples_print_what_they_claim(module):
    found = doctest.testmod(import_module(module))
    assert found.attempted > 0 and found.failed == 0
