"""The command `contbed calibrate`: fit, what the data determine of the keys,
predictions, tables and plots.

All runs are kept in its folder: an interrupted command continues from them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from contbed.errors import ConvergenceError
from contbed.many.calibrate import identify
from contbed.many.calibrate.experiments import Job, read_jobs
from contbed.many.calibrate.fit import Problem, fit
from contbed.many.calibrate.found import Calibrated, data_of, predict, warnings_of
from contbed.many.calibrate.model import SceneModel
from contbed.many.calibrate.plots import plot
from contbed.many.calibrate.posterior import require_emcee, sample
from contbed.many.calibrate.settings import CalibrationFile, read_file
from contbed.many.calibrate.write import NAMES, write
from contbed.many.store import Store
from contbed.models import MODELS, kind_of
from contbed.output.folder import prepare_study
from contbed.output.progress import Progress
from contbed.scene.toml_lines import read

FILE = "runs.jsonl"  # of all runs


def calibrate(
    path: str | Path,
    out: str | Path | None = None,
    jobs: int = 1,
    retry_failed: bool = False,
    quiet: bool = True,
    trust: bool = False,
    allow_large: bool = False,
) -> Calibrated:
    """Fit keys of scenes to measured values; tables and scenes are checked first.

    Parameters
    ----------
    path : the file of the calibration, see `contbed.many.calibrate.settings`
    out : folder for runs, tables and plots; results/NAME if absent
    jobs : processes on this machine, -1 for one a core; 1 computes in this process
    retry_failed : compute failed runs again
    quiet : no progress bar
    trust, allow_large : as in `contbed.loading.load`

    Raises
    ------
    SceneError : mistakes in the file, its tables or its scenes, before anything is
        written
    ConvergenceError : no run within the priors has a result
    ContbedError : the folder cannot be written, or emcee is needed and not installed
    """
    file = read_file(path)
    if file.settings.posterior is not None:
        require_emcee()
    work = read_jobs(file, trust, allow_large)
    folder = (Path(out) if out else Path("results") / Path(path).stem).absolute()
    prepare_study(folder, *NAMES)
    store = Store(folder / FILE, retry_failed)
    model = SceneModel(file.keys, work, store, jobs)
    found = _found(file, work, model, store, quiet)
    write(found, folder)
    plot(found, folder)
    return found


def _found(
    file: CalibrationFile,
    work: Sequence[Job],
    model: SceneModel,
    store: Store,
    quiet: bool,
) -> Calibrated:
    priors = [key.prior for key in file.keys]
    problem = Problem(model, data_of(model.points), priors)
    settings = file.settings.posterior
    steps = settings.steps if settings is not None else 0
    with Progress(
        1 + len(priors) * file.settings.profiles + steps, "steps", quiet
    ) as progress:
        done = _counter(progress)
        result = fit(problem)
        done("fit")
        intervals = {}
        for k, key in enumerate(file.keys):
            if file.settings.profiles:
                intervals[key.name] = identify.profile(problem, result, k)
                done(f"profile of {key.name}")
        samples = None
        if settings is not None:
            samples = sample(problem, result, settings, lambda: done("posterior"))
    return Calibrated(
        file,
        tuple(work),
        model.points,
        problem.data,
        result,
        identify.combinations(problem, result),
        intervals,
        samples,
        predict(model.points, result),
        len(store),
        store.before,
        store.failed(),
        [*scattering(work), *warnings_of(file, result, samples)],
    )


def scattering(work: Sequence[Job]) -> list[str]:
    """Return a warning for each scene whose results scatter with the start of the
    particles.
    """
    scenes = {job.scene.name: job for job in work}
    return [
        f"{name}: results of such a scene scatter from run to run, more than a small "
        "change of a key changes them; "
        "derivatives and intervals are not sure"
        for name, job in scenes.items()
        if MODELS[kind_of(read(job.scene)[0])].scatters
    ]


def _counter(progress: Progress) -> Callable[[str], None]:
    count = [0]

    def done(text: str) -> None:
        count[0] += 1
        progress.advance_to(count[0], text)

    return done


def require_converged(found: Calibrated) -> None:
    """Raise ConvergenceError for a fit that has not converged, after all is written."""
    if not found.fit.converged:
        raise ConvergenceError(found.warnings[0])
