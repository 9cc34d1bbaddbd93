"""Units of formulas: what is added or compared has the same one, exponents and
arguments of exp and log have none.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from typing import Any

from contbed.closures.formula import Formula
from contbed.errors import SceneError
from contbed.scene.units import exponents, unit_with

Exponents = dict[str, float]  # of the base units


def unit_of_formula(
    formula: Formula, units: Mapping[str, str], shown: Mapping[str, str]
) -> str:
    """Return the SI unit of a formula, "1" for a plain number.

    Parameters
    ----------
    formula : with names as placeholders
    units : SI unit of each placeholder
    shown : what each placeholder stands for, for messages

    Raises
    ------
    SceneError : parts with different units are added or compared, or a unit stands
        where none may
    """
    found = _Units({place: exponents(unit) for place, unit in units.items()}, shown).of(
        formula.tree
    )
    return unit_with(found) if found else "1"


class _Units:
    """Exponents of the base units of each part of a formula; None for a plain
    number, which fits to any.
    """

    def __init__(self, known: Mapping[str, Exponents], shown: Mapping[str, str]):
        self.known, self.shown = known, shown

    def of(self, node: Any) -> Exponents | None:
        """Return the exponents of a part."""
        if isinstance(node, ast.Constant):
            return None
        if isinstance(node, ast.Name):
            return self.known[node.id]
        if isinstance(node, ast.UnaryOp):
            return self.of(node.operand)
        if isinstance(node, ast.Call):
            return self.of_call(node)
        if isinstance(node.op, ast.Mult | ast.Div):
            return self.of_product(node)
        return (
            self.of_power(node)
            if isinstance(node.op, ast.Pow)
            else self.same([node.left, node.right])
        )

    def of_product(self, node: Any) -> Exponents | None:
        """Return the exponents of a product or quotient."""
        first, second = self.of(node.left), self.of(node.right)
        if first is None and second is None:
            return None
        total = dict(first or {})
        for base, power in (second or {}).items():
            total[base] = total.get(base, 0.0) + (
                power if isinstance(node.op, ast.Mult) else -power
            )
        return {base: power for base, power in total.items() if power}

    def of_power(self, node: Any) -> Exponents | None:
        """Return the exponents of a power."""
        base, exponent = self.of(node.left), self.of(node.right)
        if exponent:
            raise SceneError(
                f"the exponent {self.told(node.right)} has a unit; it must be a plain "
                "number"
            )
        if not base:
            return base
        try:
            number = float(ast.literal_eval(node.right))
        except (ValueError, TypeError):
            raise SceneError(
                f"{self.told(node.left)} has a unit; its exponent must be a number"
            ) from None
        return {unit: power * number for unit, power in base.items()}

    def of_call(self, node: Any) -> Exponents | None:
        """Return the exponents of a function."""
        if node.func.id in ("abs", "max", "min"):
            return self.same(node.args)
        found = self.of(node.args[0])
        if node.func.id == "sqrt":
            return (
                None
                if found is None
                else {base: 0.5 * power for base, power in found.items()}
            )
        if found:
            what = f"{node.func.id} of {self.told(node.args[0])}"
            raise SceneError(
                f"{what}, which has the unit {unit_with(found)}; divide it by one"
            )
        return found

    def same(self, parts: list[Any]) -> Exponents | None:
        """Return the exponents that all parts have."""
        given = [
            (part, found) for part in parts if (found := self.of(part)) is not None
        ]
        for part, found in given[1:]:
            if found != given[0][1]:
                first = f"{self.told(given[0][0])} is in {unit_with(given[0][1])}"
                raise SceneError(
                    f"{first}, {self.told(part)} in {unit_with(found)}; they cannot be "
                    "added or compared"
                )
        return given[0][1] if given else None

    def told(self, node: Any) -> str:
        """Return a part as it is written."""
        return re.sub(
            r"\b_\d+\b", lambda match: self.shown[match[0]], ast.unparse(node)
        )
