"""Former names of tables and keys of a scene, and the message that names the present
one.

A pattern is a dotted key such as "time.initial_solid" or "boundary.NAME.fluid.inflow";
NAME is any name. Items of a list of tables count as the list: "initial.layer.eps_s".
The present name repeats each NAME in its order; one more NAME stays as it is. A text
with spaces in place of the present name is the whole message. "NAME:inlet" is a name
whose table has the type "inlet". A key that has become a table, "boundary.NAME.gas" now
"boundary.NAME.gas.wall", is a former one as long as it holds something else than a
table.

The names of all kinds of scenes stand in `renamed.csv` beside this file.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from contbed.scene.toml_lines import KeyPath

NAME = "NAME"


@cache
def renamed(kind: str) -> Mapping[str, str]:
    """Return the present names of keys of a kind of scene by the former ones."""
    text = Path(__file__).with_name("renamed.csv").read_text(encoding="utf-8")
    rows = csv.reader(text.splitlines())
    return {former: present for name, former, present in rows if name == kind}


def take_former_keys(
    values: dict[str, Any], renamed: Mapping[str, str]
) -> list[tuple[KeyPath, str]]:
    """Remove former keys from the values of a scene; return where they were and what
    to write instead.
    """
    found: dict[KeyPath, str] = {}
    for pattern, new in renamed.items():
        for path in _matches(values, tuple(pattern.split("."))):
            if _is_former(values, path, pattern, new):
                found[path] = _message(pattern, new, path)
    for path in sorted(found, key=len, reverse=True):
        _remove(values, path)
    return list(found.items())


def _matches(
    values: Any, steps: tuple[str, ...], path: KeyPath = ()
) -> Iterator[KeyPath]:
    """Yield the paths of the values that a pattern fits."""
    if not steps:
        yield path
    elif isinstance(values, list):
        for index, item in enumerate(values):
            yield from _matches(item, steps, (*path, index))
    elif isinstance(values, dict):
        (first, _, kind), rest = steps[0].partition(":"), steps[1:]
        for key in list(values) if first == NAME else [first]:
            if key in values and (not kind or _type(values[key]) == kind):
                yield from _matches(values[key], rest, (*path, key))


def _type(table: Any) -> Any:
    """Return the type that a table names."""
    return table.get("type") if isinstance(table, dict) else None


def _is_former(values: Any, path: KeyPath, pattern: str, new: str) -> bool:
    """Return whether a value stands under a former name; a table does not where the
    key has become one.
    """
    for key in path:
        values = values[key]
    return not (new.startswith(f"{pattern}.") and isinstance(values, dict))


def _message(pattern: str, new: str, path: KeyPath) -> str:
    if " " in new:
        return new
    return f"this key is called '{_substituted(pattern, new, path)}' now"


def _is_name(step: str) -> bool:
    """Return whether a step of a pattern stands for any name."""
    return step.partition(":")[0] == NAME


def _substituted(pattern: str, new: str, path: KeyPath) -> str:
    """Return a new name with the names of a path in place of NAME."""
    keys = [key for key in path if isinstance(key, str)]
    names = [
        key
        for step, key in zip(pattern.split("."), keys, strict=True)
        if _is_name(step)
    ]
    steps = new.split(".")
    places = [index for index, step in enumerate(steps) if _is_name(step)]
    for index, name in zip(places, names, strict=False):
        steps[index] = name
    return ".".join(steps)


def _remove(values: Any, path: KeyPath) -> None:
    """Remove a key, and tables that become empty by it; an item of a list stays, so
    that others keep their places.

    A table that is already gone, as it had become empty, is not missed.
    """
    table = values
    for key in path[:-1]:
        if isinstance(table, dict) and key not in table:
            return
        table = table[key]
    table.pop(path[-1], None)
    above = path[:-1]
    if above and not table and isinstance(above[-1], str):
        _remove(values, above)
