"""Commands that run a scene many times: sweeps, derivatives, optima, cascades from
particles, calibrations.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from typer import Argument, Option

from contbed.cli.terminal import (
    AllowLarge,
    OutFolder,
    Quiet,
    SceneFile,
    Settings,
    Trust,
    WithReport,
    complain,
    load_scene,
    overrides_of,
    resume,
    usual_engine,
    warn,
)

RetryFailed = Annotated[
    bool, Option("--retry-failed", help="compute failed runs again")
]
Jobs = Annotated[
    int, Option("--jobs", metavar="N", help="processes; -1 for one a core")
]
NoProgress = Annotated[bool, Option("--quiet", help="no progress")]


def sweep(
    study: Annotated[
        Path,
        Argument(
            metavar="STUDY", help="a TOML file with a scene and values of its keys"
        ),
    ],
    jobs: Jobs = -1,
    out: OutFolder = None,
    retry_failed: RetryFailed = False,
    quiet: NoProgress = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Run the scenes of a study.

    Runs that a former call finished are not repeated. Writes a table and plots.
    """
    _require_jobs(jobs)
    _one_thread_a_process()
    from contbed.many.sweep.sweep import sweep as run_all

    folder = out or Path("results") / study.stem
    resume[:] = [(folder / "runs", 0.0, "the same command")]
    done = run_all(study, folder, jobs, retry_failed, quiet, trust, allow_large)
    warn(done.warnings)
    for text in done.failures():
        complain(text)
    if done.study.sample is not None:
        from contbed.many.uncertainty.write import table
        from contbed.many.uncertainty.write import write as write_uncertainty

        found = write_uncertainty(done.study, done.rows, folder)
        if found is not None:
            warn(found.warnings)
            print(table(found))
    finished = len(done.rows) - len(done.failed)
    print(
        f"{finished} of {len(done.rows)} runs are finished, {done.before} were before; "
        f"see {folder / 'table.csv'}"
    )
    if done.failed:
        raise typer.Exit(3)


def compare(
    scene: SceneFile,
    models: Annotated[
        str,
        Option("--models", metavar="A,B,C", help="packed_bed,two_fluid and the like"),
    ],
    out: OutFolder = None,
    settings: Settings = None,
    report: WithReport = False,
    quiet: NoProgress = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Run one reactor by several models.

    Shows the results that more than one model has, their differences, the time of each
    run and what each leaves out.
    """
    from contbed.many.compare import compare as run_all

    folder = out or Path("results") / f"{scene.stem}-compared"
    if report:
        from contbed.report.write import FILE, require_place, write

        require_place(folder / FILE)
    wanted = [name.strip() for name in models.split(",") if name.strip()]
    found = run_all(
        scene,
        wanted,
        folder,
        overrides_of(settings),
        quiet=quiet,
        trust=trust,
        allow_large=allow_large,
    )
    print(found.text())
    if report:
        done = [folder / outcome.model for outcome in found.outcomes]
        write(done, folder / FILE)
    print(f"results are in {folder}")
    if any(outcome.problem for outcome in found.outcomes):
        raise typer.Exit(3)


def sensitivities(
    scene: SceneFile,
    qoi: Annotated[
        list[str],
        Option(
            "--qoi", metavar="RESULT", help="T_fluid_out_K and the like; repeatable"
        ),
    ],
    to: Annotated[
        list[str] | None,
        Option(
            "--to",
            metavar="KEY",
            help="such as packed_bed.porosity; all that the scene gives",
        ),
    ] = None,
    out: OutFolder = None,
    settings: Settings = None,
    as_json: Annotated[
        bool, Option("--json", help="print JSON instead of the table")
    ] = False,
    engine: Annotated[
        Literal["skfem", "dolfinx"] | None,
        Option("--engine", help="dolfinx: PETSc, the default under mpirun"),
    ] = None,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Show derivatives of results by keys.

    All continuous keys that a scene gives are taken; the largest derivatives come
    first.
    """
    loaded = load_scene(scene, settings, trust, allow_large)
    import json

    from contbed.many.derivatives import sensitivities as design
    from contbed.output.folder import prepare_study
    from contbed.output.summary import plain

    folder = out or Path("results") / f"{scene.stem}-sensitivities"
    prepare_study(folder, f"{design.FILE}.*")
    made = design.sensitivities(loaded, qoi, to or (), engine or usual_engine())
    if made is None:
        return
    found, about = made
    design.write(found, about, folder, loaded.title)
    print(json.dumps(plain(about), indent=1) if as_json else design.table(found, about))
    if not as_json:
        print(f"table and picture are in {folder}")


def optimise(
    design: Annotated[
        Path,
        Argument(
            metavar="DESIGN", help="a TOML file: scene, keys, objective and constraints"
        ),
    ],
    out: OutFolder = None,
    retry_failed: RetryFailed = False,
    quiet: Quiet = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Find the best values of keys of a scene.

    Constraints are obeyed, and what each of them costs is shown.
    """
    _one_thread_a_process()
    from contbed.many.optimise.found import OPTIMUM, SETTLED
    from contbed.many.optimise.optimise import optimise as search

    folder = out or Path("results") / design.stem
    resume[:] = [(folder / "runs", 0.0, "the same command")]
    done = search(
        design,
        folder,
        retry_failed,
        quiet,
        trust,
        allow_large,
        lambda text: warn([text]),
    )
    warn(done.found.remarks)
    if not quiet:
        print(done.text())
    print(f"{done.found.status}: {done.found.why}")
    print(
        f"{len(done.evaluations)} evaluations, {done.before} were before, "
        f"{done.failed} failed; results are in {folder}"
    )
    if done.found.status not in (OPTIMUM, SETTLED):
        raise typer.Exit(3)


def cascade(
    file: Annotated[
        Path,
        Argument(
            metavar="CASCADE", help="a TOML file: scene, packings, laws of a particle"
        ),
    ],
    out: OutFolder = None,
    retry_failed: RetryFailed = False,
    quiet: Quiet = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Compute a bed with closures from particles.

    Packings of particles give the closures; their scatter gives each result a band,
    split by its causes.
    """
    from contbed.many.cascade.run import cascade as compute

    folder = out or Path("results") / file.stem
    resume[:] = [(folder / "particles", 0.0, "the same command")]
    done = compute(file, folder, retry_failed, quiet, trust, allow_large)
    warn(done.warnings)
    if not quiet:
        print(done.text())
    print(f"{done.runs} runs, {done.before} were before; results are in {folder}")


def calibrate(
    data: Annotated[
        Path,
        Argument(
            metavar="DATA",
            help="a TOML file with scenes, measured tables and keys to fit",
        ),
    ],
    jobs: Jobs = 1,
    out: OutFolder = None,
    retry_failed: RetryFailed = False,
    quiet: NoProgress = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Fit keys of scenes to measured values.

    Gives the keys with intervals, what the data cannot determine, and predictions with
    bands.
    """
    _require_jobs(jobs)
    from contbed.many.calibrate import calibrate as command
    from contbed.many.calibrate.write import table

    folder = out or Path("results") / data.stem
    resume[:] = [(folder / "runs.jsonl", 0.0, "the same command")]
    found = command.calibrate(
        data, folder, jobs, retry_failed, quiet, trust, allow_large
    )
    warn(found.warnings)
    print(table(found))
    print(
        f"{found.runs} runs, {found.before} were before, {len(found.failed)} failed; "
        f"results are in {folder}"
    )
    command.require_converged(found)


def _one_thread_a_process() -> None:
    """Let libraries compute on one thread, so that results do not depend on the
    process to the last digit.
    """
    for name in (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
    ):
        os.environ[name] = "1"


def _require_jobs(jobs: int) -> None:
    """Raise typer.BadParameter unless `jobs` is a number of processes, or -1 for one
    a core.
    """
    if jobs == 0 or jobs < -1:
        raise typer.BadParameter("a number of processes, or -1", param_hint="--jobs")


COMMANDS: tuple[Callable[..., Any], ...] = (
    compare,
    sweep,
    sensitivities,
    optimise,
    cascade,
    calibrate,
)
"""Commands that `contbed.cli.commands` registers."""
