"""The command line. Commands import what they need when they run, so that help and mistakes come at once."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from typer import Argument, Option

from contbed import __version__, lookup
from contbed.errors import ContbedError, SceneError, interrupt_in

SIZE = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")  # how many processes mpirun started
RANK = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "SLURM_PROCID")  # number of a process, set by what started it

_resume: list[tuple[Path, str]] = []  # what must be there to go on, and the command that does

app = typer.Typer(
    name="contbed",
    help="Finite-element continuum models for packed, moving and fluidized beds.",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

SceneFile = Annotated[Path, Argument(metavar="SCENE", help="a TOML file")]
OutFolder = Annotated[Path | None, Option("--out", metavar="DIR", help="folder for the results")]
Settings = Annotated[
    list[str] | None, Option("--set", metavar="KEY=VALUE", help="replace a value, such as mesh.refine=2; repeatable")
]


Trust = Annotated[
    bool, Option("--trust", help="let files of the scene run programs: commands in a .geo, extensions of Cantera")
]
Threads = Annotated[
    int | None,
    Option("--threads", metavar="N", min=1, help="cores to use; by default all, where faster"),
]
AllowLarge = Annotated[
    bool, Option("--allow-large", help="take sizes that are refused otherwise: memory, numbers of cells, files")
]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code. Errors are plain lines on stderr, never a traceback."""
    _resume.clear()
    try:
        code = app(list(sys.argv[1:] if arguments is None else arguments), "contbed", standalone_mode=False)
        sys.stdout.flush()
        if code == 130:
            _complain(_interrupted())
        return int(code or 0)
    except ContbedError as error:
        if interrupt_in(error) is not None:
            _complain(_interrupted())
            return 130
        _complain(str(error) or type(error).__name__)
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        _complain(_interrupted())
        return 130
    except BrokenPipeError:  # the reader, such as head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        _complain(f"contbed: {error.filename or 'file'}: {error.strerror or error}")
        return 1
    except Exception as error:
        if interrupt_in(error) is not None:
            _complain(_interrupted())
            return 130
        # The base of typer's usage errors is private; they alone can describe themselves.
        if not hasattr(error, "format_message"):
            raise
        _complain(f"contbed: {error.format_message()}")
        _complain("contbed --help shows the commands")
        return 2


def _version(wanted: bool) -> None:
    if wanted:
        print(f"contbed {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[bool, Option("--version", help="print the version", is_eager=True, callback=_version)] = False,
) -> None:
    pass


@app.command()
def run(
    scene: SceneFile,
    out: OutFolder = None,
    quiet: Annotated[bool, Option("--quiet", help="no progress, no table")] = False,
    restart: Annotated[Path | None, Option("--restart", metavar="DIR", help="continue from its checkpoint")] = None,
    settings: Settings = None,
    engine: Annotated[
        Literal["skfem", "dolfinx"] | None, Option("--engine", help="dolfinx: PETSc, the default under mpirun")
    ] = None,
    threads: Threads = None,
    report: Annotated[bool, Option("--report", help="write report.html into DIR as well")] = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Solve a scene and write its results to DIR; if not given, to that of the restart, else to results/SCENE."""
    folder = out or restart or Path("results") / scene.stem
    try:
        loaded = _load(scene, settings, trust, allow_large)
    except SceneError as error:
        if folder != restart:
            from contbed.output.folder import mark_failed

            mark_failed(folder, "bad scene", str(error))
        raise
    from contbed.runner import run as solve

    if not quiet:
        _tell_when_compiling(loaded)
    command = f"contbed run {shlex.quote(str(scene))} --restart {shlex.quote(str(folder))}"
    _resume[:] = [(folder / "checkpoint.npz", command)]
    engine = engine or ("dolfinx" if any(int(os.environ.get(name, "1")) > 1 for name in SIZE) else "skfem")
    try:
        result = solve(loaded, out=folder, quiet=quiet, restart=restart, engine=engine, threads=threads)
    except ContbedError:
        if report and (folder / "summary.json").exists():
            _write_report([folder])
        raise
    if report and result is not None:
        _write_report([folder])
    if not quiet and result is not None:
        print(result.table())
        print(f"results are in {folder}" + (f", and the report is {folder / 'report.html'}" if report else ""))


@app.command()
def check(
    scenes: Annotated[list[Path], Argument(metavar="SCENE...", help="TOML files")],
    settings: Settings = None,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Say whether scenes are right; all mistakes with file, line and remedy. Nothing is solved or written."""
    problems = []
    for scene in scenes:
        try:
            loaded = _load(scene, settings, trust, allow_large)
        except SceneError as error:
            problems += error.problems
        else:
            for text in loaded.warnings:
                print(f"warning: {text}")
            print(f"{scene}: ok{', with warnings' if loaded.warnings else ''}")
    if problems:
        raise SceneError(problems)


@app.command()
def plan(scene: SceneFile, settings: Settings = None, trust: Trust = False, allow_large: AllowLarge = False) -> None:
    """Show what a scene builds and what it leaves out, with unknowns and memory."""
    loaded = _load(scene, settings, trust, allow_large)
    from contbed.models import plan as make
    from contbed.trial import predicted_time

    _tell_when_compiling(loaded)
    planned = make(loaded)
    print(planned, flush=True)
    if time := predicted_time(planned):
        print(time)


@app.command()
def warm() -> None:
    """Compile all loops now, at install time, so that no run has to wait for it."""
    from contbed.warm import warm as each

    total = 0.0
    for name, seconds in each():
        print(f"{name}: {seconds:.1f} s", flush=True)
        total += seconds
    print(f"ready after {total:.1f} s of CPU")


@app.command()
def converge(
    scene: SceneFile,
    levels: Annotated[int, Option("--levels", metavar="N", min=2, max=12, help="number of meshes")] = 4,
    out: OutFolder = None,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Refine the mesh of a scene: error or difference, observed order and time of each level."""
    from contbed.verify.converge import converge as study

    print(study(scene, levels, out or Path("results") / f"{scene.stem}-converge", trust, allow_large))


@app.command()
def bench(
    study: Annotated[Path, Argument(metavar="STUDY", help="a study's folder")],
    out: OutFolder = None,
    trust: Annotated[bool, Option("--trust", help="let it run the programs that the study names")] = False,
) -> None:
    """Run time against error of a study, by the programs that it names."""
    from contbed.verify.bench import bench as measure

    print(measure(study, out or Path("results") / f"{study.name}-bench", trust))


@app.command()
def sweep(
    study: Annotated[Path, Argument(metavar="STUDY", help="a TOML file with a scene and values of its keys")],
    jobs: Annotated[int, Option("--jobs", metavar="N", help="processes; -1 for one a core")] = -1,
    out: OutFolder = None,
    scheduler: Annotated[
        str | None, Option("--scheduler", metavar="tcp://HOST:PORT", help="compute on this dask cluster")
    ] = None,
    retry_failed: Annotated[bool, Option("--retry-failed", help="compute failed runs again")] = False,
    quiet: Annotated[bool, Option("--quiet", help="no progress")] = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Run every scene of a study that has not been run, then write a table and plots."""
    if jobs == 0 or jobs < -1:
        raise typer.BadParameter("a number of processes, or -1", param_hint="--jobs")
    if scheduler is not None and not re.fullmatch(r"([a-z]+://)?(\[[0-9a-fA-F:]+\]|[^\s:/\[\]]+):\d{1,5}", scheduler):
        raise typer.BadParameter(f"{scheduler!r} is not an address like tcp://HOST:8786", param_hint="--scheduler")
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"  # also where this process computes, so that all get the same to the last digit
    from contbed.sweep.sweep import sweep as run_all

    folder = out or Path("results") / study.stem
    _resume[:] = [(folder / "runs", "the same command")]
    done = run_all(study, folder, jobs, scheduler, retry_failed, quiet, trust, allow_large)
    for text in done.warnings:
        _complain(f"warning: {text}")
    for text in done.failures():
        _complain(text)
    if done.study.sample is not None:
        from contbed.uncertainty.write import table
        from contbed.uncertainty.write import write as write_uncertainty

        found = write_uncertainty(done.study, done.rows, folder)
        if found is not None:
            for text in found.warnings:
                _complain(f"warning: {text}")
            print(table(found))
    finished = len(done.rows) - len(done.failed)
    print(f"{finished} of {len(done.rows)} runs are finished, {done.before} were before; see {folder / 'table.csv'}")
    if done.failed:
        raise typer.Exit(3)


@app.command()
def sensitivities(
    scene: SceneFile,
    qoi: Annotated[list[str], Option("--qoi", metavar="RESULT", help="T_fluid_out_K and the like; repeatable")],
    to: Annotated[
        list[str] | None, Option("--to", metavar="KEY", help="bed.porosity and the like; all that the scene gives")
    ] = None,
    out: OutFolder = None,
    settings: Settings = None,
    as_json: Annotated[bool, Option("--json", help="print JSON instead of the table")] = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Show the derivatives of results with respect to the continuous keys of a scene, the largest first."""
    loaded = _load(scene, settings, trust, allow_large)
    import json

    from contbed.design import sensitivities as design
    from contbed.output.summary import plain

    found, about = design.sensitivities(loaded, qoi, to or ())
    folder = out or Path("results") / f"{scene.stem}-sensitivities"
    design.write(found, about, folder, loaded.title)
    print(json.dumps(plain(about), indent=1) if as_json else design.table(found, about))
    if not as_json:
        print(f"table and picture are in {folder}")


@app.command()
def optimise(
    design: Annotated[Path, Argument(metavar="DESIGN", help="a TOML file: scene, keys, objective and constraints")],
    out: OutFolder = None,
    retry_failed: Annotated[bool, Option("--retry-failed", help="compute failed runs again")] = False,
    quiet: Annotated[bool, Option("--quiet", help="no progress, no table")] = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Find the best values of some keys of a scene under constraints, and what each constraint costs."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"  # so that a search that goes on takes the same steps to the last digit
    from contbed.design.found import OPTIMUM
    from contbed.design.optimise import optimise as search

    folder = out or Path("results") / design.stem
    _resume[:] = [(folder / "runs", "the same command")]
    done = search(design, folder, retry_failed, quiet, trust, allow_large)
    for text in done.found.remarks:
        _complain(f"warning: {text}")
    if not quiet:
        print(done.text())
    print(f"{done.found.status}: {done.found.why}")
    print(
        f"{len(done.evaluations)} evaluations, {done.before} were before, {done.failed} failed; results are in {folder}"
    )
    if done.found.status != OPTIMUM:
        raise typer.Exit(3)


@app.command()
def cascade(
    file: Annotated[Path, Argument(metavar="CASCADE", help="a TOML file: scene, packings, laws of a particle")],
    out: OutFolder = None,
    retry_failed: Annotated[bool, Option("--retry-failed", help="compute failed runs again")] = False,
    quiet: Annotated[bool, Option("--quiet", help="no progress, no table")] = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Packings of particles give closures, these the results of a bed: with a band, and what makes it."""
    from contbed.design.cascade.run import cascade as compute

    folder = out or Path("results") / file.stem
    _resume[:] = [(folder / "particles", "the same command")]
    done = compute(file, folder, retry_failed, quiet, trust, allow_large)
    for text in done.warnings:
        _complain(f"warning: {text}")
    if not quiet:
        print(done.text())
    print(f"{done.runs} runs, {done.before} were before; results are in {folder}")


@app.command()
def calibrate(
    data: Annotated[Path, Argument(metavar="DATA", help="a TOML file with scenes, measured tables and keys to fit")],
    jobs: Annotated[int, Option("--jobs", metavar="N", help="processes; -1 for one a core")] = 1,
    out: OutFolder = None,
    retry_failed: Annotated[bool, Option("--retry-failed", help="compute failed runs again")] = False,
    quiet: Annotated[bool, Option("--quiet", help="no progress")] = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Fit keys of scenes to measured values: keys with intervals, what the data do not see, predictions with bands."""
    if jobs == 0 or jobs < -1:
        raise typer.BadParameter("a number of processes, or -1", param_hint="--jobs")
    from contbed.calibration import calibrate as command
    from contbed.calibration.write import table

    folder = out or Path("results") / data.stem
    _resume[:] = [(folder / "runs.jsonl", "the same command")]
    found = command.calibrate(data, folder, jobs, retry_failed, quiet, trust, allow_large)
    for text in found.warnings:
        _complain(f"warning: {text}")
    print(table(found))
    print(f"{found.runs} runs, {found.before} were before, {len(found.failed)} failed; results are in {folder}")
    command.require_converged(found)


@app.command()
def report(
    folders: Annotated[
        list[Path], Argument(metavar="DIR...", help="folders of runs, or that of a sweep or calibration")
    ],
    out: Annotated[
        Path | None, Option("--out", metavar="FILE", help="file to write; report.html in DIR if absent")
    ] = None,
) -> None:
    """Write one HTML file of a run, of several, of a sweep or a calibration, which needs no network and no server."""
    print(f"the report is {_write_report(folders, out)}")


@app.command()
def animate(
    folder: Annotated[Path, Argument(metavar="DIR", help="folder of a transient run")],
    out: Annotated[
        Path | None, Option("--out", metavar="FILE", help="a .gif or .mp4; animation.gif in DIR if absent")
    ] = None,
    field: Annotated[str | None, Option("--field", metavar="NAME", help="which field, such as T_solid")] = None,
    rate: Annotated[int, Option("--rate", metavar="N", min=1, max=60, help="frames per second")] = 10,
) -> None:
    """Write a film of a field of a transient run: a plane, a cut through a box, or particles from the side."""
    from contbed.report.animate import animate as film

    print(f"the film is {film(folder, out, field, rate)}")


@app.command()
def validate(
    names: Annotated[
        list[str] | None, Argument(metavar="NAME...", help="measured beds; all short ones if absent")
    ] = None,
    out: OutFolder = None,
    as_json: Annotated[bool, Option("--json", help="print summary.json instead of the table")] = False,
    long: Annotated[bool, Option("--long", help="those that take more than a minute as well")] = False,
) -> None:
    """Compare the models with measured beds: deviation, uncertainty and verdict of each, a table and a picture."""
    import json

    from contbed.validation import case, report, score

    cases = [case.read_case(name) for name in names or case.names()]
    folder = out or Path("results") / "validation"
    folder.mkdir(parents=True, exist_ok=True)
    chosen = [one for one in cases if names or long or not one.settings.long]
    done = [score.validate(one, folder / one.name) for one in chosen]
    report.write(done, folder)
    print(json.dumps(report.summary(done), indent=1) if as_json else report.table(done))
    for one in done:
        for text in one.result.warnings:
            _complain(f"{one.case.name}: warning: {text}")
    left = [one.name for one in cases if one not in chosen]
    if left:
        _complain(f"left out, as they take more than a minute: {', '.join(left)}; --long runs them")
    if not as_json:
        print(f"results are in {folder}")


for _command in lookup.COMMANDS:
    app.command(_command.__name__.strip("_"))(_command)


def _write_report(folders: list[Path], file: Path | None = None) -> Path:
    from contbed.report.write import write

    return write(folders, file)


def _interrupted() -> str:
    """Return what to say after Ctrl-C: how to go on, where there is a state to go on from."""
    for needed, command in _resume:
        if needed.exists():
            return f"interrupted; to go on: {command}"
    return "interrupted"


def _tell_when_compiling(scene: Any) -> None:
    from contbed.models import model_of

    if model_of(scene).compiles:
        from contbed.compiled_cache import tell_when_compiling

        tell_when_compiling()


def _load(path: Path, settings: list[str] | None, trust: bool, allow_large: bool) -> Any:
    from contbed.loading import load

    values = dict(_assignment(text) for text in settings or [])
    return load(path, values, trust=trust, allow_large=allow_large)


def _assignment(text: str) -> tuple[str, Any]:
    """KEY=VALUE, the value as in TOML; what is not TOML is a text, so that units need no second pair of quotes."""
    import tomllib

    key, equals, value = text.partition("=")
    if not equals:
        raise typer.BadParameter(f"{text!r} is not KEY=VALUE", param_hint="--set")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        return key.strip(), value.strip()


def _complain(text: str) -> None:
    """Print a message on stderr; of the processes that mpirun started the first speaks for all."""
    if not any(os.environ.get(name, "0").strip("0") for name in RANK):
        print(text, file=sys.stderr)
