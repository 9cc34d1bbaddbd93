"""Reading of a design file; mistakes are collected, each with file:line and remedy."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal

from contbed import fields
from contbed.errors import SceneError
from contbed.loading import load
from contbed.many import value_sets
from contbed.many.derivatives.differences import seeds
from contbed.many.optimise.bounds import DesignKey, entries, read_key
from contbed.many.optimise.expression import Expression, read_expression
from contbed.many.optimise.problem import Constraint, Design, is_key, plain, require_possible
from contbed.many.sweep.study import relocated
from contbed.models import model_of
from contbed.scene import schema
from contbed.scene.names import nearest, nearest_of
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import KeyPath, Origin, dotted, one_line, parse_key, read
from contbed.scene.units import exponents, to_si
from contbed.scene.values import value_at

_KEYS = ("title", "scene", "minimise", "maximise", "constraints", "keys", "runs", "method", "repeats")
MOST_RUNS = 200  # if the file does not say
REPEATS = 3  # of a scene with seeds, if the file does not say
MOST_REPEATS = 100
_SIGN = re.compile(r"<=|>=|==|<|>|=")


def read_design(path: str | Path, trust: bool = False, allow_large: bool = False) -> Design:
    """Read a design file; flags as in `contbed.loading.load`.

    Raises
    ------
    SceneError : with file:line, all mistakes of the file, or if it has none those of its scene
    """
    path = Path(path)
    values, origin = read(path)
    reader = _Reader(values, origin)
    scene_file = reader.scene()
    reader.stop()
    scene = load(scene_file, trust=trust, allow_large=allow_large)
    method = reader.method(model_of(scene).scatters)
    repeats = reader.repeats(method, bool(seeds(scene)))
    keys = reader.keys(scene)
    reader.stop()
    try:
        load(scene_file, {key.name: plain(key, key.start) for key in keys}, trust=trust, allow_large=allow_large)
    except SceneError as error:
        places = {key.name: key.at for key in keys}
        raise SceneError([relocated(text, places)[1] for text in error.problems]) from None
    reader.units = partial(_unit, scene, {key.name: key for key in keys})
    objective, maximise = reader.objective()
    constraints = reader.constraints()
    runs = reader.runs()
    if method == "surrogate":
        reader.refuse_equalities(constraints)
    reader.stop()
    assert objective is not None
    at = origin.at(("maximise" if maximise else "minimise",))
    found = Design(
        path, str(values.get("title", "")), scene_file, scene, keys, objective, at, maximise, constraints, runs,
        method, repeats, trust, allow_large,
    )  # fmt: skip
    require_possible(found)
    return found


def _unit(scene: SceneBase, keys: Mapping[str, DesignKey], name: str) -> str:
    """Return the unit of a name in a formula."""
    if name in keys:
        return keys[name].unit
    if is_key(name):
        path = parse_key(name)
        if not isinstance(value_at(scene, name), int | float):
            numbers = [*keys, *_numbers(scene)]
            raise SceneError(f"the scene has no number {name!r}; {nearest_of(name, numbers)}")
        return schema.unit(schema.of(type(scene)), path) or "1"
    unit = fields.unit_of(name)
    if unit is None:
        raise SceneError(f"{name!r} is neither a named result nor a key; {nearest_of(name, [*fields.RESULTS, *keys])}")
    return unit


def _numbers(part: Any, above: str = "") -> list[str]:
    """Return the dotted keys of all numbers of a scene."""
    values = part if isinstance(part, Mapping) else part.model_dump(exclude_none=True)
    found = []
    for key, value in values.items():
        if isinstance(value, Mapping):
            found += _numbers(value, f"{above}{key}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            found.append(f"{above}{key}")
    return found


class _Reader:
    """Reader of the parts of a design file; it collects mistakes."""

    def __init__(self, values: dict[str, Any], origin: Origin):
        self.values, self.origin = values, origin
        self.problems: list[str] = []
        self.units: Any = None
        for key in values.keys() - set(_KEYS):
            self.say((key,), f"unknown key; {nearest(key, list(_KEYS))}")

    def say(self, path: KeyPath, text: str, shown: str = "") -> None:
        """Note a mistake at a key."""
        self.problems.append(one_line(f"{self.origin.at(path)}: {shown or dotted(path)}: {text}"))

    def stop(self) -> None:
        """Raise the mistakes that were found."""
        if self.problems:
            raise SceneError(list(dict.fromkeys(self.problems)))

    def scene(self) -> Path:
        """Return the file of the scene."""
        name = self.values.get("scene")
        if not isinstance(name, str):
            self.say(("scene",), 'missing; give the file of the scene, scene = "base.toml"')
        elif not (self.origin.base / name).is_file():
            self.say(("scene",), f'no such file: "{name}", looked for beside the design')
        if not isinstance(self.values.get("title", ""), str):
            self.say(("title",), "expected a text")
        return self.origin.base / str(name)

    def keys(self, scene: SceneBase) -> tuple[DesignKey, ...]:
        """Return the keys that may change."""
        table = self.values.get("keys")
        if not isinstance(table, dict) or not table:
            self.say(("keys",), 'missing; give bounds: [keys], mesh.length = { from = "0.2 m", to = "2 m" }')
            return ()
        found: dict[str, DesignKey] = {}
        for name, below, entry in entries(table):
            path: KeyPath = ("keys", *below)

            def say(under: tuple[str, ...], text: str, path: KeyPath = path, name: str = name) -> None:
                self.say((*path, *under), text, name)

            if name in found:
                say((), f"stands twice, also at {found[name].at}")
            elif (key := read_key(name, entry, scene, self.origin.at(path), say)) is not None:
                found[name] = key
        return tuple(found.values())

    def objective(self) -> tuple[Expression | None, bool]:
        """Return the objective, and whether it is to become large."""
        given = [key for key in ("minimise", "maximise") if key in self.values]
        if len(given) != 1:
            why = (
                "give only one of minimise and maximise" if given else "missing; a result, a key, or a formula of them"
            )
            self.say((given[-1] if given else "minimise",), why)
            return None, False
        key = given[0]
        entry: Any = self.values[key]
        unit: Any = None
        if isinstance(entry, dict):
            for name in entry.keys() - {"formula", "unit"}:
                self.say((key, name), f"unknown key; {nearest(name, ['formula', 'unit'])}")
            entry, unit = entry.get("formula"), entry.get("unit")
        if not isinstance(entry, str) or not isinstance(unit, str | None):
            self.say((key,), 'expected a formula, "mesh.length", or { formula = "...", unit = "EUR/h" }')
            return None, False
        return self.expression((key,), entry, unit), key == "maximise"

    def expression(self, path: KeyPath, text: str, unit: str | None = None) -> Expression | None:
        """Return a formula; None where it has mistakes."""
        try:
            return read_expression(text, self.units, unit)
        except SceneError as error:
            self.say(path, f'"{text}": {error}')
            return None

    def constraints(self) -> tuple[Constraint, ...]:
        """Return all constraints."""
        texts = self.values.get("constraints", [])
        if not isinstance(texts, list):
            self.say(("constraints",), 'expected a list, ["T_fluid_out_K >= 970 K"]')
            return ()
        found = (self.constraint(("constraints", k), text) for k, text in enumerate(texts))
        return tuple(one for one in found if one is not None)

    def constraint(self, path: KeyPath, text: Any) -> Constraint | None:
        """Return one constraint; None where it has mistakes."""
        signs = _SIGN.findall(text) if isinstance(text, str) else []
        if len(signs) != 1 or signs[0] not in ("<=", ">=", "=="):
            self.say(path, f'{text!r}: expected one of <=, >= and == between two sides, "pressure_drop_Pa <= 2 kPa"')
            return None
        left_text, right_text = (side.strip() for side in text.split(signs[0]))
        left = self.expression(path, left_text)
        if left is None:
            return None
        if not left.names:
            self.say(path, f'"{text}": the left side is a number; begin with the result or key')
            return None
        right = self.side(path, text, right_text, left.unit)
        return None if right is None else Constraint(text, left, signs[0], right, self.origin.at(path))

    def side(self, path: KeyPath, text: str, right: str, unit: str) -> float | Expression | None:
        """Return the right side of a constraint: a quantity in the unit of the left side, or a formula."""
        try:
            return float(right)
        except ValueError:
            pass
        if right[:1].isdigit() or right[:1] in "+-.":
            try:
                return to_si(right, unit)
            except ValueError as error:
                if re.fullmatch(r"[-+.\d\s%a-zA-Z/]*", right):
                    self.say(path, f'"{text}": {error}')
                    return None
        found = self.expression(path, right)
        if found is not None and found.names and exponents(found.unit) != exponents(unit):
            self.say(path, f'"{text}": the left side is in {unit}, the right one in {found.unit}')
            return None
        return found

    def runs(self) -> int:
        """Return the most runs."""
        return value_sets.whole(self.values, "runs", 1, value_sets.MOST_RUNS, self._say_top, default=MOST_RUNS) or 1

    def method(self, scatters: bool) -> Literal["gradient", "surrogate"]:
        """Return the method: what the file says, or by whether the results of the scene scatter."""
        given = self.values.get("method")
        if given not in (None, "gradient", "surrogate"):
            self.say(("method",), f'{given!r}; allowed: "gradient", "surrogate"')
        elif given == "gradient" and scatters:
            self.say(("method",), "results of particles and of two fluids scatter, so that there are no gradients to "
                     'follow; leave it out, or give "surrogate"')  # fmt: skip
        return "surrogate" if scatters or given == "surrogate" else "gradient"

    def repeats(self, method: str, seeded: bool) -> int:
        """Return the number of runs at a point."""
        default = REPEATS if seeded and method == "surrogate" else 1
        found = value_sets.whole(self.values, "repeats", 1, MOST_REPEATS, self._say_top, default=default) or 1
        if found > 1 and method == "gradient":
            self.say(("repeats",), 'a search by gradients runs a point once; give method = "surrogate"')
        elif found > 1 and not seeded:
            self.say(("repeats",), "the scene has no seed, so that a repeated run would be the same; leave it out")
        return found

    def refuse_equalities(self, constraints: tuple[Constraint, ...]) -> None:
        """Note equality constraints, which no point with scatter fulfils."""
        for one in constraints:
            if one.sign == "==":
                path: KeyPath = ("constraints", self.values["constraints"].index(one.text))
                self.say(path, f'"{one.text}": without gradients no point fulfils it; give two limits, with <= and >=')

    def _say_top(self, below: tuple[str, ...], text: str) -> None:
        self.say(below, text)
