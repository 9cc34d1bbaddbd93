"""Objectives and constraints of a design: formulas of keys of the scene and named
results, with units.

    mesh.length
    pressure_drop_Pa * boundary.left.gas.velocity
    0.5*"k_eff [W/m/K]" + 0.1

A name with a point is a key of the scene, any other a named result; one whose name has
a unit in brackets stands in quotes. Plain numbers are in SI and take the unit of what
they are added to.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from contbed.closures.formula import FUNCTIONS, Formula, parse_formula
from contbed.errors import SceneError
from contbed.fem.ad.dual import Dual
from contbed.many.optimise.dimensions import unit_of_formula

# a name in quotes, or a dotted or plain one; the digits and the letter e of a number
# are none
_NAME = re.compile(
    r'"([^"]+)"|(?<![\w.])([A-Za-z_][\w-]*(?:\.(?:[\w-]+))+|[A-Za-z_]\w*)'
)


@dataclass(frozen=True)
class Expression:
    """A formula of named values in SI.

    text : as it is written
    names : keys and results that it uses
    unit : SI unit of its value, "1" for a plain number
    """

    text: str
    names: tuple[str, ...]
    unit: str
    formula: Formula
    places: tuple[str, ...]

    def __call__(self, values: Mapping[str, float]) -> float:
        """Return the value for named values; nan where it has none, as at a division
        by zero.
        """
        found = {
            place: np.float64(values[name])
            for place, name in zip(self.places, self.names, strict=True)
        }
        with np.errstate(all="ignore"):
            try:
                return float(self.formula(found))
            except (ArithmeticError, ValueError):
                return math.nan

    def derivatives(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the derivative to each name, by dual numbers."""
        found = {
            place: Dual(np.float64(values[name]), {name: np.float64(1.0)})
            for place, name in zip(self.places, self.names, strict=True)
        }
        with np.errstate(all="ignore"):
            tangents = getattr(self.formula(found), "tangents", {})
        return {name: float(tangents.get(name, 0.0)) for name in self.names}


def read_expression(
    text: str, unit_of: Callable[[str], str], unit: str | None = None
) -> Expression:
    """Read a formula.

    Parameters
    ----------
    text : the formula
    unit_of : returns the SI unit of a name, "1" for a plain number; raises SceneError
        for an unknown one
    unit : of the value, such as "EUR"; the units of the parts are then not compared, as
        prices stand in the numbers

    Raises
    ------
    SceneError : it is no formula, has an unknown name, or adds what has different units
    """
    names: dict[str, str] = {}

    def placed(match: re.Match[str]) -> str:
        name = match[1] or match[2]
        if (
            match[1] is None
            and name in FUNCTIONS
            and text[match.end() :].lstrip().startswith("(")
        ):
            return name
        return names.setdefault(name, f"_{len(names)}")

    try:
        formula = parse_formula(_NAME.sub(placed, text))
    except SceneError as error:  # speaks of the places of names
        named = {place: name for name, place in names.items()}
        raise SceneError(
            re.sub(r"\b_\d+\b", lambda match: named.get(match[0], match[0]), str(error))
        ) from None
    units = {place: unit_of(name) for name, place in names.items()}
    if unit is None:
        unit = (
            next(iter(units.values()))
            if formula.text.strip() in units
            else unit_of_formula(
                formula, units, {place: name for name, place in names.items()}
            )
        )
    return Expression(text, tuple(names), unit, formula, tuple(names.values()))
