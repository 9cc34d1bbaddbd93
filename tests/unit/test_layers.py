"""Who may import whom: no circles between files, and only downwards through the layers.

The docstring of `contbed.models` describes the modules of a physics. Imports inside of
functions count like those at the top of a file, and so do names of modules given to
`import_module`; the package's own `__init__.py` is left out, which only names what
users import.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

import contbed
from contbed.models import MODELS

PACKAGE = Path(contbed.__file__).parent
# from the top to the bottom; a layer imports itself and what is below
LAYERS = (
    ("cli", "__main__"),
    ("report",),
    ("many",),
    ("runner",),
    ("ranks",),
    ("explain", "loading"),
    (
        "cfd_dem",
        "developed_flow",
        "bubbling_bed",
        "packed_bed",
        "reacting_bed",
        "single_particle",
    ),
    ("dem", "two_fluid", "radiation"),
    ("result",),
    ("engine",),
    ("course",),
    ("models", "plan_text", "balance", "output"),
    ("particle",),
    ("fem", "mesh"),
    ("chemistry",),
    ("solvers", "materials", "closures"),
    ("scene",),
    ("compiled",),
    ("fields", "errors", "arrays"),
)


def modules() -> dict[str, Path]:
    """All modules without the leading "contbed."."""
    found = {}
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        if name:
            found[name] = path
    return found


def imports(path: Path, known: dict[str, Path]) -> set[str]:
    """Modules of contbed that a file imports anywhere."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if (
            isinstance(node, ast.ImportFrom)
            and node.module
            and node.module.split(".")[0] == "contbed"
        ):
            base = node.module.removeprefix("contbed").lstrip(".")
            for alias in node.names:
                full = f"{base}.{alias.name}" if base else alias.name
                found.add(full if full in known else base)
        elif isinstance(node, ast.Call) and _name(node.func) == "import_module":
            found |= {
                item.value.removeprefix("contbed.")
                for item in node.args
                if isinstance(item, ast.Constant)
                and str(item.value).startswith("contbed.")
            }
        elif isinstance(node, ast.Import):
            found |= {
                alias.name.removeprefix("contbed.")
                for alias in node.names
                if alias.name.startswith("contbed.")
            }
    return found - {""}


def _name(function: ast.expr) -> str:
    """Return the last part of the name that is called."""
    return (
        function.attr
        if isinstance(function, ast.Attribute)
        else getattr(function, "id", "")
    )


KNOWN = modules()
# `arrays` names types in annotations, which any module may use
TYPES = {"arrays"}


@pytest.fixture(scope="module")
def graph() -> dict[str, set[str]]:
    """Return what each module imports."""
    return {name: imports(path, KNOWN) - {name} - TYPES for name, path in KNOWN.items()}


def layer(name: str) -> int:
    """Number of the layer of a module: that of the longest name that fits."""
    fits = [
        (len(entry), k)
        for k, row in enumerate(LAYERS)
        for entry in row
        if f"{name}.".startswith(f"{entry}.")
    ]
    assert fits, f"contbed.{name} has no place in LAYERS"
    return max(fits)[1]


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules that import each other (strongly connected components,
    Tarjan 1972).
    """
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph.get(node, ()):
            if other not in graph:
                continue
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            group = []
            while not group or group[-1] != node:
                group.append(stack.pop())
            if len(group) > 1:
                found.append(sorted(group))

    for name in graph:
        if name not in index:
            visit(name)
    return found


def test_the_search_finds_a_circle():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [
        ["a", "b", "c"]
    ]


def test_no_file_imports_in_a_circle(graph):
    assert circles(graph) == []


def test_no_package_imports_in_a_circle(graph):
    rooms: dict[str, set[str]] = {}
    for name, others in graph.items():
        room = name.split(".")[0]
        rooms.setdefault(room, set()).update(other.split(".")[0] for other in others)
    assert circles({room: others - {room} for room, others in rooms.items()}) == []


def test_imports_go_downwards(graph):
    wrong = [
        f"{name} -> {other}"
        for name, others in graph.items()
        for other in others
        if layer(other) < layer(name)
    ]
    assert wrong == []


def test_physics_of_one_layer_do_not_know_each_other(graph):
    physics = {model.package for model in MODELS.values()}
    below = {
        "cfd_dem": {"dem"},
        "developed_flow": {"two_fluid"},
        "bubbling_bed": {"radiation"},
        "packed_bed": {"radiation"},
    }
    for name, others in graph.items():
        room = name.split(".")[0]
        if room in physics:
            assert {other.split(".")[0] for other in others} & physics <= {
                room
            } | below.get(room, set()), name


def test_equations_know_their_vocabulary_only():
    # discrete ordinates are swept by a method of their own, which needs banded and
    # sparse algebra
    algebra = {"ordinates.py": {"scipy"}}
    for path in PACKAGE.glob("*/equations/*.py"):
        room = path.parent.parent.name
        used = {
            name.split(".")[0]
            for name in imports(path, KNOWN) - {"fem.stabilisation"} - TYPES
        }
        assert used <= {
            room,
            "errors",
            "closures",
            "chemistry",
            "particle",
            "radiation",
        }, path
        tree = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        outside = {
            node.module.split(".")[0]
            for node in tree
            if isinstance(node, ast.ImportFrom) and node.module
        }
        allowed = (
            {"numpy", "contbed"}
            | algebra.get(path.name, set())
            | set(sys.stdlib_module_names)
        )
        assert outside <= allowed, path


def test_closures_and_outputs_know_no_physics(graph):
    for name, others in graph.items():
        room = name.split(".")[0]
        if room == "closures":
            assert {other.split(".")[0] for other in others} <= {
                "closures",
                "errors",
                "scene",
            }, name
        if room == "particle":
            assert {other.split(".")[0] for other in others} <= {
                "particle",
                "materials",
                "chemistry",
                "errors",
                "fem",
            }, name
        if room == "output":
            below = {"output", "errors", "fields", "fem"}
            assert {other.split(".")[0] for other in others} <= below, name


def test_nobody_asks_for_the_kind_of_a_scene():
    for name, path in KNOWN.items():
        text = path.read_text(encoding="utf-8")
        asks = [
            node.lineno
            for node in (ast.walk(ast.parse(text)) if "scene.kind" in text else ())
            if isinstance(node, ast.Compare)
            and isinstance(node.left, ast.Attribute)
            and node.left.attr == "kind"
            and isinstance(node.left.value, ast.Name)
            and node.left.value.id == "scene"
        ]
        assert asks == [], f"{name}: {asks}"
