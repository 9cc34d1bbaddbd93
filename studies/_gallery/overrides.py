"""Scenes as nested tables: one with the changes of another."""

from __future__ import annotations

from typing import Any


def merged(*tables: dict[str, Any]) -> dict[str, Any]:
    """Tables with those that follow on top; a table that names another `type`
    replaces the whole.
    """
    one, *others = tables
    for other in others:
        one = _merged(one, other)
    return one


def _merged(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    if "type" in other:
        return other
    both = {
        key: _merged(one[key], other[key])
        for key in one.keys() & other.keys()
        if isinstance(other[key], dict)
    }
    return {**one, **other, **both}
