"""The command `contbed cascade`: packings of particles, closures, a bed that uses them, its results with a band.

All data is in the folder: an interrupted cascade continues with the same command, and computes no packing, no point of
a packing and no run twice.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contbed.design.cascade import files
from contbed.design.cascade.band import BAND, FIT_SAMPLES, Fits, Part, Runs, parts_of, sampled, visited
from contbed.design.cascade.file import Cascade, read_cascade
from contbed.design.cascade.particles import ensemble
from contbed.errors import ConvergenceError
from contbed.fields import unit_of
from contbed.output.files import prepare
from contbed.output.progress import Progress

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outcome:
    """What a cascade found.

    base : each result with the fits to all packings and the first laws
    samples : each result of the runs with all at random, (samples,)
    ranges : what the bed visits of k_solid/k_fluid, Re and Pr
    warnings : failed runs, closures outside of their range
    """

    cascade: Cascade
    base: dict[str, float]
    parts: list[Part]
    samples: dict[str, Array]
    ranges: dict[str, tuple[float, float]]
    porosities: Array
    runs: int
    before: int
    warnings: tuple[str, ...]
    folder: Path

    def band(self, name: str) -> tuple[float, float]:
        """Return the ends of the band of a result."""
        low, high = np.quantile(self.samples[name], [0.5 * (1.0 - BAND), 0.5 * (1.0 + BAND)])
        return float(low), float(high)

    def shares(self, name: str) -> dict[str, float]:
        """Return the share of each part in the sum of the variances of a result."""
        squares = {part.name: part.deviation[name] ** 2 for part in self.parts}
        total = sum(squares.values())
        return {part: square / total if total else 0.0 for part, square in squares.items()}

    def text(self) -> str:
        """Return results, bands and parts as lines."""
        lines = []
        for name, value in self.base.items():
            unit = unit_of(name)
            low, high = self.band(name)
            with_unit = "" if unit in (None, "1", "-") else f" {unit}"
            lines.append(f"{name}: {value:.6g}{with_unit}, {BAND:.0%} between {low:.6g} and {high:.6g}{with_unit}")
            for part, share in sorted(self.shares(name).items(), key=lambda item: -item[1]):
                deviation = next(one.deviation[name] for one in self.parts if one.name == part)
                lines.append(f"  {share:6.1%}  {part}: standard deviation {deviation:.3g}{with_unit}")
        return "\n".join(lines)


def cascade(
    file: str | Path,
    out: str | Path | None = None,
    retry_failed: bool = False,
    quiet: bool = True,
    trust: bool = False,
    allow_large: bool = False,
) -> Outcome:
    """Compute what a cascade file asks for.

    Parameters
    ----------
    file : TOML
    out : folder for packings, closures, runs, table and plot; results/FILE if absent
    retry_failed : compute the failed runs again
    quiet : no progress bar
    trust, allow_large : as in `contbed.loading.load`

    Raises
    ------
    SceneError : mistakes in the file or its scene, a result that the runs do not have
    ConvergenceError : the first runs failed, a packing does not come to rest
    ContbedError : the folder cannot be written
    """
    todo = read_cascade(file, trust, allow_large)
    folder = (Path(out) if out else Path("results") / todo.path.stem).absolute()
    prepare(folder)
    settings, laws = todo.settings, todo.settings.laws
    singles = settings.packings.count + FIT_SAMPLES + max(0, len(laws.conduction) - 1) + max(0, len(laws.exchange) - 1)
    steps = settings.packings.count + singles + 2 * len(todo.uncertain) + settings.samples + 3
    with Progress(steps, "steps", quiet) as progress:
        done = 0

        def tell() -> None:
            nonlocal done
            done += 1
            progress.advance_to(min(done, steps))

        runs = Runs(todo, folder, tell, retry_failed)
        ranges = visited(runs)
        fits = Fits(ensemble(todo, folder / "particles", tell), ranges)
        porosities = fits.ensemble.porosities
        best = fits.of(list(range(len(porosities))))
        base = runs.results(best, {"bed.porosity": float(porosities.mean())})
        if base is None:
            raise ConvergenceError(f"{todo.scene_file}: the run with closures from packings failed: {runs.failed[-1]}")
        parts = parts_of(runs, fits, base)
        samples = sampled(runs, fits)
    warnings = [f"{len(runs.failed)} runs failed and are left out; the first: {runs.failed[0]}"] if runs.failed else []
    if runs.outside:
        warnings.append(f"{len(runs.outside)} runs left the range of the closures that the packings gave")
    found = Outcome(
        todo, base, parts, samples, ranges, porosities, len(runs.seen), runs.before, tuple(warnings), folder
    )
    files.write(found, best)
    return found
