"""Table [continuation] of a scene: the branch of steady states over one of its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from contbed.scene import schema
from contbed.scene.checking import Mistakes
from contbed.scene.quantities import Number, Table, Whole
from contbed.scene.toml_lines import parse_key
from contbed.scene.units import exponents, number_and_unit, unit_with
from contbed.scene.values import is_constant, number_at, value_at


class Continuation(Table):
    """The branch of steady states from the value in this scene to another, through
    the folds between them.
    """

    parameter: str
    """key of a number in this scene, such as "boundary.left.gas.temperature" """
    to: Number
    """in SI"""
    points: Annotated[Whole, Field(ge=3, le=10_000)] = 400
    """at most"""

    def header(self, scene: Any) -> str:
        """Return the header of the column of the parameter: its key and unit."""
        path, given = parse_key(self.parameter), value_at(scene, self.parameter)
        if isinstance(given, str) and is_constant(path):
            unit: str | None = unit_with(exponents(number_and_unit(given)[1]))
        else:
            unit = schema.unit(schema.of(scene.__class__), path)
        return f"{self.parameter} [{unit or 1}]"


def parameter_varies(
    continuation: Continuation, tables: Mapping[str, Any], fixed: bool, examples: str
) -> Mistakes:
    """Check that the parameter of a continuation is a number of these tables that may
    vary; `fixed` says that it may not.
    """
    found = number_at(tables, continuation.parameter)
    if found is None or fixed:
        yield (
            ("continuation", "parameter"),
            "no number of this scene can be varied under this key; allowed: keys such "
            f"as {examples}",
        )
    elif found == continuation.to:
        yield (
            ("continuation", "to"),
            "is already the value in the scene; give another value to follow the "
            "solution to",
        )
