"""The page of all errors and warnings, read from the source of the package.

A message is a text of at least four words that the code raises, passes to a
function that reports, appends to a list of findings, or yields to a caller that
prints it. Values are shown as `...`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from markdown_text import code, page, table

ABOUT = (
    "All texts with which contbed refuses an input, stops a run or warns, made from the "
    "code. `...` stands for a name, a number or a list. What a scene causes begins with "
    "the file, the line and the key: `scene.toml:12: gas.pressure: ...`. A *check* is "
    "made before the run, by `contbed check`, `plan` and `run` alike, and all of its "
    "findings are printed at once; a *warning* does not stop a run and stands in its "
    "summary and report; errors end the "
    "command with an [exit code](../../reference/commands.md#exit-codes)."
)
KINDS = {
    "SceneError": "scene",
    "ConvergenceError": "solution",
    "EngineError": "engine",
    "BalanceError": "balance",
    "ClosureRangeError": "range",
    "check": "check",
    "warning": "warning",
}
NOT_MESSAGES = ("explain", "plan_text")
SHORTEST = 4  # words of a message; a shorter text is part of one
REPORTING = ("error", "remark", "warn", "problem", "blamed", "refuse", "damaged")
LISTS = ("warnings", "problems", "errors", "found", "remarks")


@dataclass(frozen=True)
class Message:
    """A message as the source states it."""

    text: str
    kind: str  # the class of the error, or "warning"
    place: str  # the module


def write_page(file: Path, package: Path) -> None:
    """Write the page of all messages of a package, by rooms."""
    parts = [ABOUT]
    for room, group in groupby(
        messages(package), key=lambda each: each.place.split(".")[1]
    ):
        rows = [
            [code(each.text.replace("`", "'")), KINDS.get(each.kind, "error")]
            for each in sorted(
                group, key=lambda each: each.text.lstrip(".:'\" ").lower()
            )
        ]
        parts += [f"## {room}", table(["message", "kind"], rows)]
    page(file, "Messages", *parts)


def messages(package: Path) -> list[Message]:
    """Return all messages of a package, in the order of its modules."""
    found: dict[tuple[str, str], Message] = {}
    for path in sorted(package.rglob("*.py")):
        module = ".".join(path.relative_to(package.parent).with_suffix("").parts)
        if module.split(".")[1] in NOT_MESSAGES:
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for kind, node in _reported(tree):
            for text in _texts(node):
                found.setdefault((module, text), Message(text, kind, module))
    return list(found.values())


def _reported(tree: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Yield each reported expression with its kind; a yielded text is a finding of a
    check.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            kind = _kind_of_call(node)
            if kind:
                yield from ((kind, argument) for argument in node.args)
        elif isinstance(node, ast.Yield) and node.value is not None:
            yield "check", node.value
        elif isinstance(node, ast.FunctionDef) and _is_reporting(node.name):
            for inner in ast.walk(node):
                if isinstance(inner, ast.Return) and inner.value is not None:
                    yield "check", inner.value


def _kind_of_call(call: ast.Call) -> str:
    """Return the kind of message that a call reports, or an empty text."""
    name = _name(call.func)
    if name[:1].isupper():
        return name if name.endswith(("Error", "Failed", "Exit", "Parameter")) else ""
    if name in ("append", "extend", "add"):
        owner = _name(call.func.value) if isinstance(call.func, ast.Attribute) else ""
        if owner not in LISTS:
            return ""
        return "warning" if owner in ("warnings", "remarks") else "check"
    if name in ("remark", "warn"):
        return "warning"
    return "error" if _is_reporting(name) else ""


def _is_reporting(name: str) -> bool:
    return any(word in name.lower() for word in (*REPORTING, *LISTS))


def _name(node: ast.AST) -> str:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _texts(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.Call):
        return
    text = _template(node)
    if text is not None:
        if len(text.split()) >= SHORTEST and not text.startswith("<"):
            yield " ".join(text.split())
        return
    for child in ast.iter_child_nodes(node):
        yield from _texts(child)


def _template(node: ast.AST) -> str | None:
    """Return the text of a literal, of a formatted literal or of a sum of these."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        parts = [
            part.value if isinstance(part, ast.Constant) else "..."
            for part in node.values
        ]
        return "".join(str(part) for part in parts)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = _template(node.left), _template(node.right)
        if left is None and right is None:
            return None
        return (left or "...") + (right or "...")
    return None
