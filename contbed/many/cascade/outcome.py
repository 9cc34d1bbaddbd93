"""What a cascade found: results with their bands and the parts of these."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.fields import behind, unit_of
from contbed.many.cascade.band import BAND, Part
from contbed.many.cascade.file import Cascade
from contbed.many.cascade.measured import Held


@dataclass(frozen=True)
class Outcome:
    """What a cascade found.

    base : each result with the fits to all packings and the first laws
    samples : each result of the runs with all at random, (samples,)
    drawn : what was drawn for these runs: packing, laws by name, numbers of the scene
        by key in SI, (samples,)
    held : the measured points beside their band; None without any
    ranges : what the bed visits of k_solid/k_fluid, Re and Pr
    warnings : failed runs, closures outside of their range
    """

    cascade: Cascade
    base: dict[str, float]
    parts: list[Part]
    samples: dict[str, Array]
    drawn: dict[str, list[Any]]
    held: Held | None
    ranges: dict[str, tuple[float, float]]
    porosities: Array
    runs: int
    before: int
    warnings: tuple[str, ...]
    folder: Path

    def band(self, name: str) -> tuple[float, float]:
        """Return the ends of the band of a result."""
        low, high = np.quantile(
            self.samples[name], [0.5 * (1.0 - BAND), 0.5 * (1.0 + BAND)]
        )
        return float(low), float(high)

    def shares(self, name: str) -> dict[str, float]:
        """Return the share of each part in the sum of the variances of a result."""
        squares = {part.name: part.deviation[name] ** 2 for part in self.parts}
        total = sum(squares.values())
        return {
            part: square / total if total else 0.0 for part, square in squares.items()
        }

    def text(self) -> str:
        """Return results, bands and parts as lines."""
        lines = []
        for name, value in self.base.items():
            unit = behind(unit_of(name))
            low, high = self.band(name)
            lines.append(
                f"{name}: {value:.6g}{unit}, {BAND:.0%} between {low:.6g} and "
                f"{high:.6g}{unit}"
            )
            for part, share in sorted(
                self.shares(name).items(), key=lambda item: -item[1]
            ):
                deviation = next(
                    one.deviation[name] for one in self.parts if one.name == part
                )
                lines.append(
                    f"  {share:6.1%}  {part}: standard deviation {deviation:.3g}{unit}"
                )
        if self.held is not None and self.cascade.measured is not None:
            case, points = self.cascade.measured, self.held
            lines.append(
                f"{case.name}: {len(points.best)} measured points, {points.inside:.0%} "
                f"in the band of {BAND:.0%}, "
                f"{points.inside_measured:.0%} with their own scatter of "
                f"{case.uncertainty:g} {case.unit}"
            )
            lines += [
                f"  {share:6.1%}  {part}"
                for part, share in sorted(
                    points.shares.items(), key=lambda item: -item[1]
                )
            ]
        return "\n".join(lines)
