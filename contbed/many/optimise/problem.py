"""A design file: a scene, the keys that may change, what is to become small or large,
and what must hold.

    title = "Shortest heater"
    scene = "heater.toml"
    minimise = "mesh.length"                             # or maximise = ...; a key, a result, or a formula of them
    constraints = ["T_fluid_out_K >= 700 degC", "pressure_drop_Pa <= 2 kPa"]         # <=, >= or ==

    [keys]
    mesh.length = { from = "0.2 m", to = "2 m" }
    boundary.right.solids.pebbles.velocity = { from = "0.2 mm/s", to = "2 mm/s" }

`minimise = { formula = "120*tubes.perimeter - 3e-5*tubes_W", unit = "EUR/h" }` has
prices in its numbers: the units of its parts are then not compared. `runs` is the most
points that are computed. `method` is "gradient" or "surrogate", the latter where
results scatter if it is left out. `repeats` is the number of seeds at each point of a
surrogate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, product
from pathlib import Path
from typing import Literal

import numpy as np

from contbed.arrays import Array, Flags
from contbed.errors import SceneError
from contbed.fields import behind
from contbed.loading import load
from contbed.many.optimise.bounds import DesignKey
from contbed.many.optimise.expression import Expression
from contbed.many.value_sets import tidy
from contbed.scene.tables import SceneBase
from contbed.scene.values import value_at


@dataclass(frozen=True)
class Constraint:
    """A constraint: left <= right, >= or ==; `right` is a number in the unit of the
    left side, or a formula.
    """

    text: str
    left: Expression
    sign: str
    right: float | Expression
    at: str

    @property
    def names(self) -> tuple[str, ...]:
        """Keys and results of both sides."""
        return self.left.names + (
            self.right.names if isinstance(self.right, Expression) else ()
        )

    def bound(self, values: Mapping[str, float]) -> float:
        """Return the value of the right side."""
        return self.right(values) if isinstance(self.right, Expression) else self.right

    def excess(self, values: Mapping[str, float]) -> float:
        """Return by how much the sides miss each other, in their unit: > 0
        where <= or >= does not hold.
        """
        beyond = self.left(values) - self.bound(values)
        return -beyond if self.sign == ">=" else beyond

    def derivatives(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the derivatives of `excess` to names."""
        found = self.left.derivatives(values)
        if isinstance(self.right, Expression):
            for name, slope in self.right.derivatives(values).items():
                found[name] = found.get(name, 0.0) - slope
        return (
            {name: -slope for name, slope in found.items()}
            if self.sign == ">="
            else found
        )


@dataclass(frozen=True)
class Design:
    """What a design file asks for."""

    file: Path
    title: str
    scene_file: Path
    scene: SceneBase
    keys: tuple[DesignKey, ...]
    objective: Expression
    objective_at: str
    maximise: bool
    constraints: tuple[Constraint, ...]
    runs: int
    method: Literal["gradient", "surrogate"]
    repeats: int

    @property
    def start(self) -> Array:
        """The values to begin with, (keys,)."""
        return np.array([key.start for key in self.keys])

    @property
    def low(self) -> Array:
        """The lower bounds, (keys,)."""
        return np.array([key.low for key in self.keys])

    @property
    def high(self) -> Array:
        """The upper bounds, (keys,)."""
        return np.array([key.high for key in self.keys])

    @property
    def equality(self) -> Flags:
        """Which constraints are equalities, (constraints,)."""
        return np.array([one.sign == "==" for one in self.constraints], dtype=bool)

    @property
    def sign(self) -> float:
        """What the objective is multiplied by to become small: -1 to maximise it."""
        return -1.0 if self.maximise else 1.0

    @property
    def results(self) -> tuple[str, ...]:
        """Named results that objective and constraints use."""
        return tuple(name for name in self._names if not is_key(name))

    @property
    def _names(self) -> dict[str, None]:
        """Keys and results that objective and constraints use."""
        used = (self.objective.names, *(one.names for one in self.constraints))
        return dict.fromkeys(chain.from_iterable(used))

    def fixed(self) -> dict[str, float]:
        """Return the values of the scene's keys that expressions use and that do not
        change.
        """
        changed = {key.name for key in self.keys}
        return {
            name: float(value_at(self.scene, name))
            for name in self._names
            if is_key(name) and name not in changed
        }

    def values_at(self, point: Array) -> dict[str, float]:
        """Return the keys that expressions may use by name, at a point (keys,)."""
        return self.fixed() | {
            key.name: float(value) for key, value in zip(self.keys, point, strict=True)
        }

    def scene_at(self, point: Array) -> SceneBase:
        """Return the scene with the keys at a point (keys,)."""
        values = {
            key.name: plain(key, value)
            for key, value in zip(self.keys, point, strict=True)
        }
        origin = self.scene.origin
        return load(
            self.scene_file,
            values,
            trust=origin.trust,
            allow_large=origin.allow_large,
        )


def is_key(name: str) -> bool:
    """Return whether a name in a formula is a key of the scene; any other is a named
    result.
    """
    return "." in name and " " not in name


def plain(key: DesignKey, value: float) -> float:
    """Return a value as a scene takes it: integers unchanged, others rounded to what
    is the same everywhere.
    """
    return round(value) if key.whole else tidy(float(value))


def require_possible(found: Design) -> None:
    """Raise SceneError for constraints that no point can fulfil, as far as is known
    without a run.
    """
    problems = []
    names = [key.name for key in found.keys]
    for one in found.constraints:
        if all(is_key(name) for name in one.names):
            least, corner = _least_excess(found, one)
            if least > 0.0:
                where = ", ".join(
                    f"{key.name} = {key.shown(value)}" for key, value in zip(found.keys, corner, strict=True)
                    if key.name in one.names
                )  # fmt: skip
                short = (
                    f"missed by at least {least:.4g}{behind(one.left.unit)}, at "
                    f"{where or 'any point'}"
                )
                problems.append(
                    f'{one.at}: "{one.text}" cannot hold within the bounds of '
                    f"{', '.join(names)}: {short}"
                )
    for k, one in enumerate(found.constraints):
        for other in found.constraints[:k]:
            gap = _gap(one, other)
            if gap > 0.0:
                by = f"{gap:.4g}{behind(one.left.unit)}"
                problems.append(
                    f'{one.at}: "{one.text}" contradicts "{other.text}" by {by}; '
                    "change one"
                )
    if problems:
        raise SceneError(problems)


def _least_excess(found: Design, one: Constraint) -> tuple[float, Array]:
    """Return the least excess of a constraint on keys over the corners of the
    bounds, and that corner.
    """
    ends = [
        (key.low, key.high) if key.name in one.names else (key.start,)
        for key in found.keys
    ]
    corners = [np.array(corner) for corner in product(*ends)]
    excess = np.array([one.excess(found.values_at(corner)) for corner in corners])
    if one.sign == "==":
        excess = np.zeros(1) if excess.min() <= 0.0 <= excess.max() else np.abs(excess)
    k = int(np.argmin(excess))
    return float(excess[k]), corners[k]


def _gap(one: Constraint, other: Constraint) -> float:
    """Return by how much two bounds of the same quantity exclude each other; 0 if
    they do not.
    """
    if (
        one.left.text != other.left.text
        or isinstance(one.right, Expression)
        or isinstance(other.right, Expression)
    ):
        return 0.0
    bounds = [(c.sign, c.right) for c in (one, other) if isinstance(c.right, float)]
    lower = [value for sign, value in bounds if sign in (">=", "==")]
    upper = [value for sign, value in bounds if sign in ("<=", "==")]
    return float(max(lower, default=-np.inf) - min(upper, default=np.inf))
