"""Closure file -> closure: reads and checks what `contbed.closures.transferred` describes; errors with file:line."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from contbed.closures.transferred import ARGUMENTS, FORMAT, UNITS, Transferred
from contbed.errors import SceneError
from contbed.scene.toml_lines import KeyPath, dotted, read

_SCALES = ("log", "linear")
_TABLES = ("format", "kind", "form", "variables", "terms", "parameters", "range", "residuals", "provenance")
_POWER = ("base", "a", "b", "c")


def closure_of(file: str, base: Path, kind: str) -> Transferred:
    """The closure in a file, which is looked for in `base`. SceneError with the file's line if it cannot be used."""
    path = base / file
    try:
        stamp = path.stat().st_mtime_ns, path.stat().st_size
    except (OSError, ValueError):
        raise SceneError(f"no closure file {file!r}; looked for {path.absolute()}") from None
    found = _cached(str(path), file, stamp)
    if found.sheet.kind != kind:
        raise SceneError(f"{file} holds a closure of kind {found.sheet.kind!r}, wanted kind {kind!r}")
    return found


@lru_cache(maxsize=64)
def _cached(path: str, name: str, stamp: tuple[int, int]) -> Transferred:
    content, origin = read(path)
    problems = [f"{origin.at(where)}: {dotted(where)}: {text}" for where, text in _mistakes(content)]
    if problems:
        raise SceneError("; ".join(problems))
    return Transferred(name, content)


def _mistakes(content: Mapping[str, Any]) -> list[tuple[KeyPath, str]]:
    """What is wrong with the content of a closure file."""
    if "format" not in content:
        return [(("format",), "missing: this is no closure file of contbed")]
    if content["format"] != FORMAT:
        return [(("format",), f"is {content['format']!r}; this version of contbed reads {FORMAT}: extract it anew")]
    found: list[tuple[KeyPath, str]] = [((key,), "unknown key") for key in content if key not in _TABLES]
    kind, form = content.get("kind"), content.get("form")
    if kind not in list(UNITS):
        return [*found, (("kind",), f"unknown kind {kind!r}; known: {', '.join(UNITS)}")]
    forms = ("log_polynomial", "power") if kind == "nusselt" else ("log_polynomial",)
    if form not in forms:
        return [*found, (("form",), f"unknown form {form!r} of a {kind}; known: {', '.join(forms)}")]
    found += _power_mistakes(content) if form == "power" else _polynomial_mistakes(content, kind)
    for key, bounds in _table(content, "range").items():
        if not set(key.split("/")) <= set(ARGUMENTS[kind]) or key.count("/") > 1:
            found.append((("range", key), f"names no argument of a {kind}; they are {', '.join(ARGUMENTS[kind])}"))
        if not (isinstance(bounds, list) and len(bounds) == 2 and all(map(_number, bounds)) and bounds[0] <= bounds[1]):
            found.append((("range", key), "is not [lowest, highest]"))
    variables = ("Re", "Pr") if form == "power" else tuple(_table(content, "variables"))
    found += [(("range",), f"does not bound {name}") for name in variables if name not in _table(content, "range")]
    return found


def _power_mistakes(content: Mapping[str, Any]) -> list[tuple[KeyPath, str]]:
    parameters = _table(content, "parameters")
    return [
        (("parameters", name), "is missing or has no number as its value")
        for name in _POWER
        if not isinstance(parameters.get(name), dict) or not _number(parameters[name].get("value"))
    ]


def _polynomial_mistakes(content: Mapping[str, Any], kind: str) -> list[tuple[KeyPath, str]]:
    found: list[tuple[KeyPath, str]] = []
    variables = _table(content, "variables")
    for name, rule in variables.items():
        path: KeyPath = ("variables", name)
        if not set(name.split("/")) <= set(ARGUMENTS[kind]) or name.count("/") > 1:
            found.append((path, f"names no argument of a {kind}; they are {', '.join(ARGUMENTS[kind])}"))
        if not isinstance(rule, dict) or rule.get("scale") not in _SCALES or not _number(rule.get("reference")):
            found.append((path, 'is not {scale = "log" or "linear", reference = a number}'))
        elif rule["scale"] == "log" and not rule["reference"] > 0:
            found.append((path, "has a logarithm of a reference that is not above 0"))
    terms = content.get("terms")
    if not variables or not isinstance(terms, list) or not terms:
        return [*found, (("terms",), "a log_polynomial needs [variables] and [[terms]]")]
    for index, term in enumerate(terms):
        powers = term.get("powers") if isinstance(term, dict) else None
        whole = isinstance(powers, list) and all(isinstance(p, int) and p >= 0 for p in powers)
        if not whole or len(powers or []) != len(variables) or not _number(term.get("value")):
            found.append((("terms", index), f"needs {len(variables)} whole powers >= 0 and a number as its value"))
    return found


def _table(content: Mapping[str, Any], name: str) -> dict[str, Any]:
    table = content.get(name)
    return table if isinstance(table, dict) else {}


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
