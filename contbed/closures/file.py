"""Closure file -> closure: reads and checks what `contbed.closures.transferred`
describes; errors with file:line.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

from contbed.closures.transferred import ARGUMENTS, FORMAT, UNITS, Transferred
from contbed.errors import SceneError
from contbed.scene.quantities import LARGEST
from contbed.scene.toml_lines import KeyPath, read

_SCALES = ("log", "linear")
_TABLES = (
    "format",
    "kind",
    "form",
    "variables",
    "terms",
    "parameters",
    "range",
    "residuals",
    "provenance",
)
_POWER = ("base", "a", "b", "c")


def closure_of(file: str, base: Path, kind: str) -> Transferred:
    """Return the closure in a file in the folder `base`; SceneError with the file's
    line if it cannot be used.
    """
    path = base / file
    try:
        stamp = path.stat().st_mtime_ns, path.stat().st_size
    except (OSError, ValueError):
        raise SceneError(
            f"no closure file {file!r}; looked for {path.absolute()}"
        ) from None
    found = _cached(str(path), file, stamp)
    if found.sheet.kind != kind:
        raise SceneError(
            f"{file} holds a closure of kind {found.sheet.kind!r}, wanted kind {kind!r}"
        )
    return found


@lru_cache(maxsize=64)
def _cached(path: str, name: str, stamp: tuple[int, int]) -> Transferred:
    content, origin = read(path)
    problems = [f"{origin.place(where)}: {text}" for where, text in _mistakes(content)]
    if problems:
        raise SceneError("; ".join(problems))
    return Transferred(name, content)


def _mistakes(content: Mapping[str, Any]) -> list[tuple[KeyPath, str]]:
    """Return what is wrong with the content of a closure file."""
    if "format" not in content:
        return [(("format",), "missing: this is no closure file of contbed")]
    if type(content["format"]) is not int or content["format"] != FORMAT:
        return [
            (
                ("format",),
                f"is {content['format']!r}; this version of contbed reads {FORMAT}: "
                "extract it anew",
            )
        ]
    found: list[tuple[KeyPath, str]] = [
        ((key,), "unknown key") for key in content if key not in _TABLES
    ]
    kind, form = content.get("kind"), content.get("form")
    if kind not in list(UNITS):
        return [
            *found,
            (("kind",), f"unknown kind {kind!r}; known: {', '.join(UNITS)}"),
        ]
    forms = ("log_polynomial", "power") if kind == "nusselt" else ("log_polynomial",)
    if form not in forms:
        return [
            *found,
            (
                ("form",),
                f"unknown form {form!r} of a {kind}; known: {', '.join(forms)}",
            ),
        ]
    found += (
        _power_mistakes(content)
        if form == "power"
        else _polynomial_mistakes(content, kind)
    )
    found += _range_mistakes(content, kind)
    variables = ("Re", "Pr") if form == "power" else tuple(_table(content, "variables"))
    found += [
        (("range",), f"does not bound {name}")
        for name in variables
        if name not in _table(content, "range")
    ]
    if not _table(content, "provenance"):
        found.append(
            (
                ("provenance",),
                "is missing: say where the closure comes from, such as scene = ...",
            )
        )
    return found or _value_mistakes(content) or _hash_mistakes(content)


def _range_mistakes(content: Mapping[str, Any], kind: str) -> list[tuple[KeyPath, str]]:
    found: list[tuple[KeyPath, str]] = []
    for key, bounds in _table(content, "range").items():
        where: KeyPath = ("range", key)
        if not set(key.split("/")) <= set(ARGUMENTS[kind]) or key.count("/") > 1:
            found.append(
                (
                    where,
                    f"names no argument of a {kind}; they are "
                    f"{', '.join(ARGUMENTS[kind])}",
                )
            )
        if not _interval(bounds):
            found.append((where, "is not [lowest, highest]"))
        elif bounds[0] < 0.0:
            found.append((where, f"begins below 0, where {key} never is"))
        elif (
            bounds[0] == 0.0
            and _table(_table(content, "variables"), key).get("scale") == "log"
        ):
            found.append((where, "begins at 0, whose logarithm is infinite"))
    return found


def _value_mistakes(content: Mapping[str, Any]) -> list[tuple[KeyPath, str]]:
    """Corners of the range where the closure has no value or one below zero."""
    variables = (
        ("Re", "Pr") if content["form"] == "power" else tuple(content["variables"])
    )
    place = "parameters" if content["form"] == "power" else "terms"
    for corner in product(*(content["range"][name] for name in variables)):
        value = _value(content, corner)
        if not 0.0 <= value <= LARGEST:
            at = ", ".join(
                f"{name} = {x:g}" for name, x in zip(variables, corner, strict=True)
            )
            return [
                ((place,), f"give {value:g} at {at}, which is no transport coefficient")
            ]
    return []


def _value(content: Mapping[str, Any], corner: Sequence[float]) -> float:
    """Return the value of a form, without its unit, where its variables are those of
    `corner`.
    """
    try:
        if content["form"] == "power":
            base, a, b, c = (content["parameters"][name]["value"] for name in _POWER)
            return float(base + a * corner[0] ** b * corner[1] ** c)
        scaled = [
            math.log(x / rule["reference"])
            if rule["scale"] == "log"
            else x - rule["reference"]
            for x, rule in zip(corner, content["variables"].values(), strict=True)
        ]
        powers = (
            math.prod(t**n for t, n in zip(scaled, term["powers"], strict=True))
            for term in content["terms"]
        )
        return math.exp(
            sum(
                term["value"] * power
                for term, power in zip(content["terms"], powers, strict=True)
            )
        )
    except (OverflowError, ZeroDivisionError):
        return math.inf


def content_hash(content: Mapping[str, Any]) -> str:
    """Hash of what a closure file holds besides its provenance."""
    text = json.dumps(
        {key: value for key, value in content.items() if key != "provenance"},
        sort_keys=True,
    )
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _hash_mistakes(content: Mapping[str, Any]) -> list[tuple[KeyPath, str]]:
    given = content["provenance"].get("hash")
    if given is None or given == content_hash(content):
        return []
    text = (
        "does not belong to this content: the file was changed after the fit; "
        "extract it anew or remove the hash"
    )
    return [(("provenance", "hash"), text)]


def _power_mistakes(content: Mapping[str, Any]) -> list[tuple[KeyPath, str]]:
    parameters = _table(content, "parameters")
    found: list[tuple[KeyPath, str]] = []
    for name in _POWER:
        part = _table(parameters, name)
        if not _number(part.get("value")):
            found.append(
                (("parameters", name), "is missing or has no number as its value")
            )
        elif "interval" in part and not _interval(part["interval"]):
            found.append(
                (("parameters", name), "has an interval that is not [lowest, highest]")
            )
    return found


def _polynomial_mistakes(
    content: Mapping[str, Any], kind: str
) -> list[tuple[KeyPath, str]]:
    found: list[tuple[KeyPath, str]] = []
    variables = _table(content, "variables")
    for name, rule in variables.items():
        path: KeyPath = ("variables", name)
        if not set(name.split("/")) <= set(ARGUMENTS[kind]) or name.count("/") > 1:
            found.append(
                (
                    path,
                    f"names no argument of a {kind}; they are "
                    f"{', '.join(ARGUMENTS[kind])}",
                )
            )
        if (
            not isinstance(rule, dict)
            or rule.get("scale") not in _SCALES
            or not _number(rule.get("reference"))
        ):
            found.append(
                (path, 'is not {scale = "log" or "linear", reference = a number}')
            )
        elif rule["scale"] == "log" and not rule["reference"] > 0:
            found.append((path, "has a logarithm of a reference that is not above 0"))
    terms = content.get("terms")
    if not variables or not isinstance(terms, list) or not terms:
        return [
            *found,
            (("terms",), "a log_polynomial needs [variables] and [[terms]]"),
        ]
    for index, term in enumerate(terms):
        powers = term.get("powers") if isinstance(term, dict) else None
        whole = isinstance(powers, list) and all(
            type(p) is int and p >= 0 for p in powers
        )
        if (
            not whole
            or len(powers or []) != len(variables)
            or not _number(term.get("value"))
        ):
            found.append(
                (
                    ("terms", index),
                    f"needs {len(variables)} whole powers >= 0 and a number as its "
                    "value",
                )
            )
        elif "interval" in term and not _interval(term["interval"]):
            found.append(
                (("terms", index), "has an interval that is not [lowest, highest]")
            )
    return found


def _table(content: Mapping[str, Any], name: str) -> dict[str, Any]:
    table = content.get(name)
    return table if isinstance(table, dict) else {}


def _interval(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 2
        and all(map(_number, value))
        and value[0] <= value[1]
    )


def _number(value: Any) -> bool:
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and math.isfinite(value)
    )
