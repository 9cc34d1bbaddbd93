"""What the tests of the engine for MPI take from contbed exists: they are skipped
where DOLFINx is not installed.
"""

import ast
import importlib.util
from pathlib import Path

import pytest

TESTS = sorted((Path(__file__).parents[1] / "ranks").glob("*.py"))


def names_of(module: str) -> set[str]:
    """Names at the top of `module` and the modules in it, without importing it."""
    spec = importlib.util.find_spec(module)
    assert spec is not None and spec.origin is not None, module
    found = {
        path.stem
        for folder in spec.submodule_search_locations or ()
        for path in Path(folder).iterdir()
    }
    for node in ast.walk(ast.parse(Path(spec.origin).read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.ImportFrom | ast.Import):
            found |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found


@pytest.mark.parametrize("path", TESTS, ids=lambda path: path.stem)
def test_names_that_are_imported_exist(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if (
            isinstance(node, ast.ImportFrom)
            and node.module is not None
            and node.module.split(".")[0] == "contbed"
        ):
            missing = {alias.name for alias in node.names} - names_of(node.module)
            assert not missing, (
                f"{path.name}:{node.lineno}: {node.module} has no "
                f"{', '.join(sorted(missing))}"
            )
