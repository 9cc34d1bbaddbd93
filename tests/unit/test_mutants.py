"""The list of mutants fits the package: every old text is found once, and every test
exists.
"""

import ast
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))

import mutants  # noqa: E402

MUTANTS = mutants.read()


@pytest.mark.parametrize(
    "mutant", MUTANTS, ids=[f"{k}-{Path(m.file).stem}" for k, m in enumerate(MUTANTS)]
)
def test_a_mutant_fits_the_package(mutant):
    assert mutant.found == 1, (
        f"tests/mutants.toml: {mutant.old!r} is found {mutant.found} times in "
        f"{mutant.file}"
    )
    assert mutant.new != mutant.old
    file, name = mutant.test.split("::")
    functions = [item.name for item in ast.parse((ROOT / file).read_text(encoding="utf-8")).body
                 if isinstance(item, ast.FunctionDef)]  # fmt: skip
    assert name in functions, f"tests/mutants.toml: no test {mutant.test}"


def test_no_mutant_stands_twice():
    assert len({(m.file, m.old, m.new) for m in MUTANTS}) == len(MUTANTS) >= 22
