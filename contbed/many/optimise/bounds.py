"""Keys of a scene that a design may change: [keys] of its file.

[keys]
mesh.length = { from = "0.2 m", to = "2 m" }
solids.pebbles.diameter = { from = "4 mm", to = "16 mm", start = "12 mm" }      # start: that of the scene if left out
tubes.count = { from = 4, to = 20, integer = true }
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from contbed.fields import behind
from contbed.many.study_file import Say, checked, unit_of
from contbed.many.value_sets import Ends, number
from contbed.scene import schema
from contbed.scene.names import nearest
from contbed.scene.quantities import Switch
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import parse_key
from contbed.scene.values import is_constant, value_at


class Bounds(Ends):
    """Bounds of a key, and where a search begins."""

    start: Any = None
    """value at which the search begins; absent: that of the scene"""
    integer: Switch | None = None
    """whether the key takes integers only"""


@dataclass(frozen=True)
class DesignKey:
    """A key with its bounds and the value to begin with, in SI; `at` is its
    file:line.
    """

    name: str
    unit: str
    low: float
    high: float
    start: float
    whole: bool
    at: str

    @property
    def span(self) -> float:
        """The distance of the bounds."""
        return self.high - self.low

    def shown(self, value: float) -> str:
        """Return a value with its unit."""
        number = f"{value:.0f}" if self.whole else f"{value:.6g}"
        return number + behind(self.unit)


def is_range(entry: Any) -> bool:
    """Return whether an entry of [keys] holds bounds, and not keys further down."""
    return (
        not isinstance(entry, Mapping)
        or not entry
        or bool({"from", "to"} & entry.keys())
    )


def read_key(
    name: str, entry: Any, scene: SceneBase, at: str, say: Say
) -> DesignKey | None:
    """Return one key; mistakes are noted by `say(path below the entry, text)`; the
    key is then None.
    """
    node = _node(scene, name, say)
    if node is None:
        return None
    unit, whole = node
    if not isinstance(entry, Mapping):
        say((), "expected bounds, { from = ..., to = ... }")
        return None
    table = checked(Bounds, entry, say)
    if table is None:
        return None
    given = whole if table.integer is None else table.integer
    if whole and not given:
        say(
            ("integer",),
            "integer = false, but this key of the scene counts; leave it out",
        )
        return None
    if is_constant(parse_key(name)):
        unit = unit_of(name, value_at(scene, name)) or "1"
    low, high = (_number(entry, key, unit, given, say) for key in ("from", "to"))
    if low is None or high is None:
        return None
    if low >= high:
        same = (
            f"from and to are both {low:g}"
            if low == high
            else f"from, {low:g}, is above to, {high:g}; swap them"
        )
        say(
            (),
            f"{same}; give a range from the lower to the higher value"
            if low == high
            else same,
        )
        return None
    start = _start(name, entry, scene, (unit, given), (low, high), say)
    return None if start is None else DesignKey(name, unit, low, high, start, given, at)


def _node(scene: SceneBase, name: str, say: Say) -> tuple[str, bool] | None:
    """Return unit of a key, and whether it counts."""
    root = schema.of(type(scene))
    try:
        path = parse_key(name)
    except ValueError:
        say((), "not a key of a scene; write it as mesh.length")
        return None
    nodes = schema.at(root, path)
    if not nodes:
        above = next(
            tables
            for end in range(len(path) - 1, -1, -1)
            if (tables := schema.at(root, path[:end]))
        )
        known = list(
            dict.fromkeys(key for table in above for key in schema.keys(table))
        )
        say((), f"the scene has no such key; {nearest(str(path[-1]), known)}")
        return None
    options = [option for node in nodes for option in schema.options(node)]
    unit = schema.unit(root, path)
    if unit is None and not any(
        option.get("type") in ("number", "integer") for option in options
    ):
        say(
            (),
            "is no number and cannot be varied between bounds; allowed: "
            f"{schema.allowed(nodes[0])}",
        )
        return None
    return unit or "1", unit is None and all(
        option.get("type") == "integer" for option in options
    )


def _start(
    name: str,
    entry: Mapping[str, Any],
    scene: SceneBase,
    kind: tuple[str, bool],
    ends: tuple[float, float],
    say: Say,
) -> float | None:
    """Return the value to begin with: that of the entry, or of the scene."""
    unit, whole = kind
    low, high = ends
    if "start" in entry:
        start, whose = _number(entry, "start", unit, whole, say), "start"
    else:
        found = value_at(scene, name)
        if isinstance(found, str) and is_constant(parse_key(name)):
            found = number({"start": found}, "start", unit, say)
        if not isinstance(found, int | float) or isinstance(found, bool):
            say(
                (),
                f"the scene has no number here; give start = ... between {low:g} and "
                f"{high:g}",
            )
            return None
        start, whose = float(found), "the scene's value"
    if start is None:
        return None
    if not low <= start <= high:
        remedy = (
            "move it inside"
            if whose == "start"
            else "give start = ..., or widen the bounds"
        )
        say(
            ("start",) if whose == "start" else (),
            f"{whose}, {start:g}, is outside of {low:g} to {high:g}; {remedy}",
        )
        return None
    if whole and not start.is_integer():
        say((), f"the scene's value, {start:g}, is no integer; give start = ...")
        return None
    return start


def _number(
    entry: Mapping[str, Any], key: str, unit: str, whole: bool, say: Say
) -> float | None:
    """Return a number in SI."""
    value = number(entry, key, unit, say)
    if value is not None and whole and not value.is_integer():
        say((key,), f"{key} is {value:g}; the key takes integers")
        return None
    return value
