"""Every physics has the same modules, as `contbed.models` and CONTRIBUTING.md list
them.
"""

import ast
import re
from pathlib import Path

import pytest

from contbed import models

ROOT = Path(__file__).parents[2]
# each module, and what it defines
ROOM: dict[str, set[str]] = {
    "scene.py": set(),
    "checks.py": {"CHECKS", "WARNINGS"},
    "plan.py": {"plan"},
    "run.py": {"run"},
    "results.py": set(),
    "plots.py": {"plot"},
    "template.toml": set(),
}


def names(path: Path) -> set[str]:
    """Names at the top of a module."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.ImportFrom):
            found |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {target.id for target in targets if isinstance(target, ast.Name)}
    return found


@pytest.mark.parametrize("kind", models.MODELS)
def test_a_physics_has_the_modules_of_a_room(kind: str) -> None:
    model = models.MODELS[kind]
    folder = ROOT / "contbed" / model.package
    for module, defined in ROOM.items():
        assert (folder / module).is_file(), module
        if defined:
            assert defined <= names(folder / module), module
    assert model.settings in names(folder / "scene.py")
    assert all(sheet.is_file() for sheet in model.sheets().values())


def test_the_modules_of_runs_in_time_are_listed() -> None:
    section = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = section.split("| module of `course/` |")[1].split("\n## ")[0]
    listed = re.findall(r"^\| `(\w+\.py)` \|", section, flags=re.MULTILINE)
    found = {path.name for path in (ROOT / "contbed" / "course").glob("[a-z]*.py")}
    assert found == set(listed)


def test_both_lists_of_the_modules_are_this_one() -> None:
    listed = re.findall(
        r"^    ([\w.]+/?)  +\S", models.__doc__ or "", flags=re.MULTILINE
    )
    assert {name for name in listed if not name.endswith("/")} == set(ROOM)
    section = (
        (ROOT / "CONTRIBUTING.md")
        .read_text(encoding="utf-8")
        .split("## Rooms")[1]
        .split("\nRuns in time")[0]
    )
    assert re.findall(r"^\| `([\w.]+/?)` \|", section, flags=re.MULTILINE) == listed
