"""The command `contbed cascade`: packings of particles, closures, a bed that uses them,
its results with a band.

All data is in the folder: an interrupted cascade continues with the same command, and
computes no packing, no point of a packing and no run twice.
"""

from __future__ import annotations

from pathlib import Path

from contbed.errors import ConvergenceError
from contbed.many.cascade import files
from contbed.many.cascade.band import (
    BAND,
    FIT_SAMPLES,
    Fits,
    Part,
    Runs,
    parts_of,
    sampled,
    scatter_of,
    visited,
)
from contbed.many.cascade.file import read_cascade
from contbed.many.cascade.measured import held
from contbed.many.cascade.outcome import Outcome
from contbed.many.cascade.particles import ensemble
from contbed.output.folder import prepare_study
from contbed.output.progress import Progress


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
    prepare_study(folder, *files.NAMES)
    settings, laws = todo.settings, todo.settings.laws
    singles = (
        settings.packings.count
        + FIT_SAMPLES
        + max(0, len(laws.conduction) - 1)
        + max(0, len(laws.exchange) - 1)
    )
    steps = (
        settings.packings.count
        + singles
        + 2 * (len(todo.uncertain) + len(scatter_of(todo)))
        + settings.samples
        + 3
    )
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
        base = runs.results(best, todo.reactor.at(float(porosities.mean())))
        if base is None:
            raise ConvergenceError(
                f"{todo.scene_file}: the run with closures from packings failed: "
                f"{runs.failed[-1]}"
            )
        parts = parts_of(runs, fits, base)
        samples, drawn = sampled(runs, fits)
    warnings = (
        [
            f"{len(runs.failed)} runs failed and are left out; the first: "
            f"{runs.failed[0]}"
        ]
        if runs.failed
        else []
    )
    if runs.outside:
        warnings.append(
            f"{len(runs.outside)} runs left the range of the closures that the "
            "packings gave"
        )
    compared = None
    if todo.measured is not None:
        compared = held(
            todo.measured,
            base,
            {part.name: part.deviation for part in parts},
            samples,
            BAND,
        )
    asked = settings.qoi  # without the measured points
    found = Outcome(
        todo,
        {name: base[name] for name in asked},
        [
            Part(part.name, {name: part.deviation[name] for name in asked})
            for part in parts
        ],
        {name: samples[name] for name in asked},
        drawn,
        compared,
        ranges,
        porosities,
        len(runs.seen),
        runs.before,
        tuple(warnings),
        folder,
    )
    files.write(found, best)
    return found
