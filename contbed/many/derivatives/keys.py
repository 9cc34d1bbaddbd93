"""Continuous keys of a scene: numbers whose small changes change the results a little.

A key is written as in scenes and sweeps, "packed_bed.porosity", one item of a list as
"gas.T_range[1]". Integers, names, switches and choices have no derivative; numerical
settings (solver, output, mesh cells, tolerances, time steps) have one that says nothing
about the bed. `continuous` lists those that a scene gives.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from contbed.errors import SceneError
from contbed.many.study_file import unit_of
from contbed.models import model_of
from contbed.scene import schema
from contbed.scene.library import MATERIALS
from contbed.scene.names import near_names
from contbed.scene.quantities import Table
from contbed.scene.tables import Closure, SceneBase, from_library
from contbed.scene.toml_lines import KeyPath, dotted, parse_key
from contbed.scene.units import base_value
from contbed.scene.values import at, is_constant, with_value

NUMERICAL_TABLES = ("solver", "output")
NUMERICAL_KEYS = (
    "tolerance",
    "step",
    "checkpoint_every",
    "times",
    "size",
    "scale_factor",
)
ATOMS = "elements"  # numbers of atoms, which do not change a little
_ITEM = re.compile(r"(.*)\[(\d+)\]$")
_LOWER = {"exclusiveMinimum": True, "gt": True, "minimum": False, "ge": False}
_UPPER = {"exclusiveMaximum": True, "lt": True, "maximum": False, "le": False}


@dataclass(frozen=True)
class Key:
    """A continuous key of a scene, its value and SI unit, and the bounds between which
    it may be changed.

    A bound that is `open` cannot be taken itself.
    """

    name: str
    path: KeyPath
    value: float
    unit: str
    low: float = -math.inf
    high: float = math.inf
    low_is_open: bool = False
    high_is_open: bool = False

    def allows(self, value: float) -> bool:
        """Return whether the key may have a value."""
        above = value > self.low if self.low_is_open else value >= self.low
        return above and (
            value < self.high if self.high_is_open else value <= self.high
        )

    def on(self, scene: SceneBase, value: float) -> SceneBase:
        """Return the scene with another value of this key; material data that were
        taken at it follow.
        """
        if self.path[-1] == "material_temperature":
            table = at(scene, self.path[:-1])
            if getattr(table, "material", None) is not None:
                again: SceneBase = with_value(
                    scene, self.path[:-1], _at_temperature(table, value)
                )
                return again
        found: SceneBase = with_value(scene, self.path, value)
        return found


def key(scene: SceneBase, name: str) -> Key:
    """Return a continuous key of a scene by its name.

    Raises
    ------
    SceneError : it has no derivative, the scene has no such key or does not give it;
        with what to do instead
    """
    path = _path(name)
    if path is None:
        raise SceneError(
            f"{name!r} is not a dotted key; write it as in the scene: "
            "packed_bed.porosity, gas.T_range[1]"
        )
    where = scene.origin.at(path)
    root = schema.of(model_of(scene).scene)
    ways = [way for node in schema.at(root, path) for way in schema.options(node)]
    is_switch = any(way.get("type") == "boolean" for way in ways)
    value, problem = _in_si(path, at(scene, path)), None
    if isinstance(value, Table | dict):
        problem = (
            "is a table; give one of its keys: "
            f"{', '.join(_below(value)) or 'it has none'}"
        )
    elif isinstance(value, bool) or (value is None and is_switch):
        problem = "is true or false and has no derivative"
    elif isinstance(value, int):
        problem = (
            "is an integer and has no derivative; compare two runs, or use "
            "contbed sweep"
        )
    elif isinstance(value, str):
        remedy = (
            "give a number or a closure's parameters, {name = ..., a = ...}"
            if any(map(schema.is_closure, ways))
            else "use contbed sweep"
        )
        problem = f'is "{value}", a choice or a name, and has no derivative; {remedy}'
    elif isinstance(value, list | tuple):
        problem = (
            f"is a list; give one of its items, {name}[0]"
            if value
            else "is an empty list"
        )
    elif value is None:
        if ways:
            problem = (
                "is not given in the scene, so that it has no value to change; "
                "give it in the scene"
            )
        else:
            near = near_names(name, [found.name for found in continuous(scene)])
            raise SceneError(
                f"{scene.origin.name}: {name}: the scene has no such key"
                + (
                    f"; did you mean {near[0]}?"
                    if near
                    else "; contbed sensitivities without --to shows those it has"
                )
            )
    elif not math.isfinite(value):
        problem = "is not finite"
    elif _is_numerical(path):
        problem = (
            "is a setting of the numerical method, on which results must not depend"
        )
    elif _fixed_by_a_unit(scene, path):
        problem = (
            "has no derivative, as the unit of A belongs to this order; give A as a "
            "plain number, in mol, m, s and K"
        )
    if problem is not None:
        raise SceneError(f"{where}: {name} {problem}")
    return _key(scene, path, float(value))


def continuous(scene: SceneBase) -> list[Key]:
    """Return the continuous keys that a scene gives, in its order; defaults that it
    leaves alone are not among them.
    """
    return [
        _key(scene, path, value)
        for path, value in _numbers(scene, ())
        if not _fixed_by_a_unit(scene, path)
    ]


def _fixed_by_a_unit(scene: SceneBase, path: KeyPath) -> bool:
    """Return whether a key is an order to which the unit of its A belongs."""
    if len(path) != 4 or path[0] != "reactions" or path[2] != "orders":
        return False
    return isinstance(at(scene, (*path[:2], "A")), str)


def _numbers(part: Any, above: KeyPath) -> Iterator[tuple[KeyPath, float]]:
    """Yield paths and values of the numbers that a table gives."""
    if isinstance(part, Table):
        extra = part.model_extra or {}
        given: dict[Any, Any] = {
            name: getattr(part, name)
            for name in type(part).model_fields
            if name in part.model_fields_set
        }
        given |= extra
    elif isinstance(part, dict):
        given = part
    else:
        given = dict(enumerate(part))
    for name, given_value in given.items():
        path = (*above, name)
        if _is_numerical(path) or ATOMS in path:
            continue
        value = _in_si(path, given_value)
        if isinstance(value, float) and math.isfinite(value):
            yield path, value
        elif isinstance(value, Table | dict | tuple | list):
            yield from _numbers(value, path)


def _in_si(path: KeyPath, value: Any) -> Any:
    """Return the constant of a formula in SI base units, "3 1/h"; other values as they
    are.
    """
    if not isinstance(value, str) or not is_constant(path):
        return value
    try:
        return base_value(value)
    except ValueError:
        return value


def _is_numerical(path: KeyPath) -> bool:
    return path[0] in NUMERICAL_TABLES or any(
        step in NUMERICAL_KEYS for step in path if isinstance(step, str)
    )


def _key(scene: SceneBase, path: KeyPath, value: float) -> Key:
    root = schema.of(model_of(scene).scene)
    low, high, low_is_open, high_is_open = -math.inf, math.inf, False, False
    for option in [
        way for node in schema.at(root, path) for way in (node, *schema.options(node))
    ]:
        if option.get("type") not in ("number", None):
            continue
        for name, is_open in _LOWER.items():
            if name in option and option[name] >= low:
                low, low_is_open = float(option[name]), is_open
        for name, is_open in _UPPER.items():
            if name in option and option[name] <= high:
                high, high_is_open = float(option[name]), is_open
    parent = at(scene, path[:-1])
    if isinstance(parent, Closure):
        interval = _parameter_interval(parent.name, str(path[-1]))
        if interval is not None:
            low, high = interval.low, interval.high
            low_is_open, high_is_open = not interval.closed[0], not interval.closed[1]
    unit = schema.unit(root, path) or "1"
    constant = at(scene, path)
    if isinstance(constant, str):
        unit = unit_of(dotted(path), constant) or "1"
    return Key(dotted(path), path, value, unit, low, high, low_is_open, high_is_open)


def _parameter_interval(closure: str, parameter: str) -> Any:
    """Return the bounds of a closure's parameter; None where its data sheet has
    none.
    """
    from contbed.closures import registry

    for name in registry.names():
        if name == closure or name.endswith(f"_{closure}"):
            found = registry.sheet(name).bounds.get(parameter)
            if found is not None:
                return found
    return None


def _path(name: str) -> KeyPath | None:
    """Return the path of a dotted key, whose last steps may be items of lists; None
    if it is not one.
    """
    items: tuple[int, ...] = ()
    while found := _ITEM.match(name):
        name, items = found[1], (int(found[2]), *items)
    try:
        return (*parse_key(name), *items)
    except ValueError:
        return None


def _below(table: Table | dict[str, Any]) -> list[str]:
    return [
        dotted((name,))
        for name in (table if isinstance(table, dict) else type(table).model_fields)
    ]


def _at_temperature(table: Any, temperature: float) -> Any:
    """Return the table of a library material with its properties at another
    temperature [K].

    Properties that the scene gives in place of the library's stay.
    """
    given = {name: getattr(table, name) for name in table.model_fields_set}
    library = from_library(MATERIALS[table.material].phase, given)
    own = {name: value for name, value in given.items() if value != library.get(name)}
    return type(table).model_validate(own | {"material_temperature": temperature})
