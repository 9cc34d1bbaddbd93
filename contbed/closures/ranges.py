"""How closures were used: declared and used range of each argument, of one call or
collected over a run.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.closures import registry
from contbed.closures.sheet import Sheet

# relative excess of a value over a bound that is no more than rounding
_ROUNDING = 1e-9


@dataclass(frozen=True)
class ArgumentUse:
    """Declared and used range of one argument; `share_outside` is the share of
    points beyond the bounds or nan.
    """

    declared: tuple[float, float]
    used: tuple[float, float]
    share_outside: float


@dataclass(frozen=True)
class RangeUse:
    """How one run used one closure."""

    sheet: Sheet
    arguments: Mapping[str, ArgumentUse]

    @property
    def share_outside(self) -> float:
        """The largest share of points that lie outside the range of any one
        argument.
        """
        return max((use.share_outside for use in self.arguments.values()), default=0.0)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; a missing bound is None because JSON knows neither inf
        nor nan.
        """
        return {
            "name": self.sheet.name,
            "kind": self.sheet.kind,
            "source": self.sheet.source,
            "share_outside": self.share_outside,
            "ranges": {
                name: {
                    "declared": [_finite(bound) for bound in use.declared],
                    "used": [_finite(bound) for bound in use.used],
                    "share_outside": use.share_outside,
                }
                for name, use in self.arguments.items()
            },
        }


class RangeRecord:
    """Ranges that a closure was used in, collected over the states of a run."""

    def __init__(self, sheet: Sheet):
        self.sheet = sheet
        # lowest, highest, points outside, points
        self.rows = np.zeros((len(sheet.ranges), 4))

    @property
    def empty(self) -> bool:
        """Whether nothing has been added."""
        return not self.rows[:, 3].any()

    def add(self, arguments: Mapping[str, Any]) -> None:
        """Add the arguments of one call."""
        for row, (key, declared) in zip(
            self.rows, self.sheet.ranges.items(), strict=True
        ):
            values = _values(key, arguments)
            use = _argument_use(values, declared)
            if row[3] == 0.0:
                row[:2] = use.used
            elif values.size:
                row[:2] = min(row[0], use.used[0]), max(row[1], use.used[1])
            row[2:] += use.share_outside * values.size, values.size

    def use(self) -> RangeUse:
        """Return what was added so far."""
        uses = {
            key: ArgumentUse(
                declared,
                (float(low), float(high)),
                float(outside / points) if points else 0.0,
            )
            for (key, declared), (low, high, outside, points) in zip(
                self.sheet.ranges.items(), self.rows, strict=True
            )
        }
        return RangeUse(self.sheet, MappingProxyType(uses))


def usage(function: Callable[..., Any] | str, **arguments: Any) -> RangeUse:
    """Compare the arguments of a call, numbers or arrays that broadcast, with the
    declared ranges.
    """
    if isinstance(function, str):
        function = registry.get(function)
    facts: Sheet = function.sheet  # type: ignore[attr-defined]
    bound = inspect.signature(function).bind(**arguments)
    bound.apply_defaults()
    record = RangeRecord(facts)
    record.add(bound.arguments)
    return record.use()


def _values(key: str, arguments: Mapping[str, Any]) -> Array:
    """Values of the argument, or of the ratio of two, that a range belongs to."""
    top, _, bottom = key.partition("/")
    values = np.asarray(arguments[top], dtype=float)
    return values / np.asarray(arguments[bottom], dtype=float) if bottom else values


def _argument_use(values: Array, declared: tuple[float, float]) -> ArgumentUse:
    if values.size == 0:
        return ArgumentUse(declared, (math.nan, math.nan), 0.0)
    low, high = declared
    # Written as "not inside" so that nan counts as outside. Rounding of a value at a
    # bound is inside.
    outside = ~(
        (values >= low - _ROUNDING * abs(low))
        & (values <= high + _ROUNDING * abs(high))
    )
    return ArgumentUse(
        declared, (float(values.min()), float(values.max())), float(outside.mean())
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
