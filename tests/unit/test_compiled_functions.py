"""Functions without an entry from Python are called by compiled ones only: from
Python the process would end.
"""

import ast
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
INNER = {"inner", "inner_summing"}
COMPILED = {"entry", "njit", "jit", "kernel", "summing", *INNER}


def decorators(node):
    """Names of the decorators of a function, without modules and arguments."""
    called = (
        each.func if isinstance(each, ast.Call) else each
        for each in getattr(node, "decorator_list", [])
    )
    return {ast.unparse(each).rsplit(".", 1)[-1] for each in called}


def called_from_python(trees):
    """Places `module: name` where a function without an entry is named outside of
    compiled functions.
    """
    functions = {
        (module, node.name)
        for module, tree in trees.items()
        for node in tree.body
        if decorators(node) & INNER
    }
    found = []
    for module, tree in trees.items():
        names = {name: (module, name) for of, name in functions if of == module}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                names |= {
                    each.asname or each.name: (node.module, each.name)
                    for each in node.names
                }
        # what a file imports may be a module with such functions, too
        modules = {name: ".".join(place) for name, place in names.items()}

        def look(node, names=names, modules=modules, module=module):
            if isinstance(node, ast.FunctionDef) and decorators(node) & COMPILED:
                return
            if (
                isinstance(node, ast.Name)
                and isinstance(node.ctx, ast.Load)
                and names.get(node.id) in functions
            ):
                found.append(f"{module}: {node.id}")
            elif (
                isinstance(node, ast.Attribute)
                and (modules.get(getattr(node.value, "id", "")), node.attr) in functions
            ):
                found.append(f"{module}: {ast.unparse(node)}")
            for child in ast.iter_child_nodes(node):
                look(child)

        look(tree)
    return found


def test_functions_without_an_entry_are_called_by_compiled_ones_only():
    files = [
        path
        for folder in ("contbed", "tests", "studies")
        for path in (ROOT / folder).rglob("*.py")
    ]
    texts = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): path.read_text()
        for path in files
    }
    having = [
        module
        for module, text in texts.items()
        if module.startswith("contbed") and "@inner" in text
    ]
    assert having
    ways = [*having, *{f"from {module.rpartition('.')[0]} import" for module in having}]
    trees = {
        module: ast.parse(text)
        for module, text in texts.items()
        if any(way in text for way in ways)
    }
    assert (
        called_from_python(
            trees | {module: ast.parse(texts[module]) for module in having}
        )
        == []
    )


def test_such_a_call_is_seen():
    trees = {
        "a": ast.parse("@inner\ndef f(x): return x\n@kernel\ndef g(x): return f(x)\n"),
        "p.b": ast.parse(
            "from a import f, g\nfrom p import c\ng(1.0)\nf(1.0)\nc.h(1.0)\n"
        ),
        "p.c": ast.parse(
            "@inner(nogil=True)\ndef h(x): return x\ndef k(x): return h(x)\n"
        ),
    }
    assert called_from_python(trees) == ["p.b: f", "p.b: c.h", "p.c: h"]


CALLED = "from numba import njit\n@njit\ndef f(x): return x + {}\n"
CALLING = """
from pathlib import Path
from numba import njit
from contbed.compiled.functions import digest, tied
from called import f
def g(x): return 2.0 * f(x)
g = tied(njit(cache=True)(g), digest(Path(__file__).parent.glob("*.py")))
print(g(1.0), sum(g.stats.cache_hits.values()))
"""


def test_code_on_disk_is_made_anew_when_a_function_that_it_calls_changes(tmp_path):
    (tmp_path / "calling.py").write_text(CALLING)
    environment = {
        **os.environ,
        "PYTHONPATH": f"{tmp_path}:{ROOT}",
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
    }
    told = []
    for number in (1.0, 1.0, 5.0):
        (tmp_path / "called.py").write_text(CALLED.format(number))
        run = [sys.executable, "-B", "-c", "import calling"]
        told.append(
            subprocess.run(
                run, env=environment, capture_output=True, text=True, check=True
            ).stdout.split()
        )
    assert told == [["4.0", "0"], ["4.0", "1"], ["12.0", "0"]]


def test_kernels_of_two_fluids_are_tied_to_each_other():
    from contbed.two_fluid import compiled, solids_pressure

    assert (
        solids_pressure.add_compaction_velocity._cache._cache_file._source_stamp[1]
        == compiled.CONTENT
    )
