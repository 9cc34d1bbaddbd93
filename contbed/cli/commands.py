"""Entry point, and the commands for one scene.

Commands import what they need when they run, so that help comes at once.
"""

from __future__ import annotations

import os
import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from typer import Argument, Option

from contbed import __version__
from contbed.cli import lookup, studies
from contbed.cli.terminal import (
    AllowLarge,
    OutFolder,
    Quiet,
    SceneFile,
    Settings,
    Threads,
    Trust,
    WithReport,
    complain,
    interrupted,
    load_scene,
    resume,
    usual_engine,
)
from contbed.errors import ContbedError, ConvergenceError, SceneError, interrupt_in

# former commands and options, and what to do instead
FORMER = {
    "'animate'": "for a film open fields.pvd in ParaView: File > Save Animation",
    "--json": "summary.json in the folder of the results has the numbers",
    "--scheduler": "give the same command on each machine, with one --out for all",
    "--search": "contbed list shows all names",
}

app = typer.Typer(
    name="contbed",
    help="Finite-element continuum models for packed, moving and fluidized beds.",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code. Errors are plain lines on stderr,
    never a traceback.
    """
    resume.clear()
    try:
        code = app(
            list(sys.argv[1:] if arguments is None else arguments),
            "contbed",
            standalone_mode=False,
        )
        sys.stdout.flush()
        if code == 130:
            complain(interrupted())
        return int(code or 0)
    except ContbedError as error:
        if interrupt_in(error) is not None:
            complain(interrupted())
            return 130
        complain(str(error) or type(error).__name__)
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        complain(interrupted())
        return 130
    except BrokenPipeError:  # the reader, such as head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        complain(f"contbed: {error.filename or 'file'}: {error.strerror or error}")
        return 1
    except Exception as error:
        if interrupt_in(error) is not None:
            complain(interrupted())
            return 130
        if isinstance(error, OverflowError):
            complain(
                f"contbed: too large for a computer, {error.args[-1]}: values are far "
                "from any bed"
            )
            return ConvergenceError.exit_code
        # The base of typer's usage errors is private; they alone can describe
        # themselves.
        if not hasattr(error, "format_message"):
            raise
        text = error.format_message()
        complain(f"contbed: {text}")
        gone = [remedy for name, remedy in FORMER.items() if name in text]
        complain(gone[0] if gone else "contbed --help shows the commands")
        return 2


def _version(wanted: bool) -> None:
    if wanted:
        print(f"contbed {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        Option("--version", help="print the version", is_eager=True, callback=_version),
    ] = False,
) -> None:
    pass


@app.command()
def run(
    scene: SceneFile,
    out: OutFolder = None,
    quiet: Quiet = False,
    restart: Annotated[
        Path | None,
        Option("--restart", metavar="DIR", help="continue from its checkpoint"),
    ] = None,
    settings: Settings = None,
    engine: Annotated[
        Literal["skfem", "dolfinx", "lammps", "cuda"] | None,
        Option(
            "--engine",
            help="dolfinx: PETSc, the default under mpirun; lammps: settles a packing; "
            "cuda: particles on a GPU",
        ),
    ] = None,
    threads: Threads = None,
    report: WithReport = False,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Solve a scene and write its results.

    They go to DIR; without --out to the folder of --restart, else to results/SCENE.
    """
    folder = out or restart or Path("results") / scene.stem
    try:
        loaded = load_scene(scene, settings, trust, allow_large)
    except SceneError as error:
        if folder != restart:
            from contbed.output.folder import mark_failed

            mark_failed(folder, "bad scene", str(error))
        raise
    from contbed.runner import run as solve

    if report:
        _require_place(folder)
    if not quiet:
        _tell_when_compiling(loaded)
    options = [word for text in settings or [] for word in ("--set", text)]
    options += ["--engine", engine] if engine else []
    options += ["--trust"] * trust + ["--allow-large"] * allow_large
    command = shlex.join(
        ["contbed", "run", str(scene), *options, "--restart", str(folder)]
    )
    # a checkpoint that was there before is that of another run, which this one has not
    # replaced yet
    resume[:] = [
        (folder / "checkpoint.npz", 0.0 if folder == restart else time.time(), command)
    ]
    try:
        result = solve(
            loaded,
            out=folder,
            quiet=quiet,
            restart=restart,
            engine=engine or usual_engine(),
            threads=threads,
        )
    except ContbedError:
        if report and (folder / "summary.json").exists():
            _write_report([folder])
        raise
    if report and result is not None:
        _write_report([folder])
    if not quiet and result is not None:
        print(result.table())
        print(
            f"results are in {folder}"
            + (f", and the report is {folder / 'report.html'}" if report else "")
        )


@app.command()
def check(
    scenes: Annotated[list[Path], Argument(metavar="SCENE...", help="TOML files")],
    settings: Settings = None,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Check scenes without solving them.

    Every mistake is printed with file, line and remedy, also in the files that a scene
    names: meshes, mechanisms, tables, fluids. Nothing is written.
    """
    from contbed.models import plan as build
    from contbed.scene.inputs import inputs_elsewhere

    problems = []
    for scene in scenes:
        try:
            loaded = load_scene(scene, settings, trust, allow_large)
            build(loaded)
        except SceneError as error:
            problems += error.problems
        else:
            for text in loaded.warnings:
                print(f"warning: {text}")
            if others := inputs_elsewhere(loaded, loaded.origin.base):
                names = ", ".join(str(file.resolve()) for file in others)
                print(f"{scene}: reads files outside of its folder: {names}")
            print(f"{scene}: ok{', with warnings' if loaded.warnings else ''}")
    if problems:
        raise SceneError(problems)


@app.command()
def plan(
    scene: SceneFile,
    quiet: Annotated[
        bool,
        Option(
            "--quiet", help="nothing besides the plan, such as that loops are compiled"
        ),
    ] = False,
    settings: Settings = None,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Show the model that a scene builds.

    Also what it leaves out, the number of unknowns and the memory.
    """
    loaded = load_scene(scene, settings, trust, allow_large)
    from contbed.models import plan as make

    if not quiet:
        _tell_when_compiling(loaded)
    print(make(loaded))


@app.command()
def warm(
    clear: Annotated[
        bool,
        Option("--clear", help="remove all compiled code instead, as to uninstall"),
    ] = False,
) -> None:
    """Compile all loops now.

    Meant for the time of installation, so that no run has to wait for it.
    """
    if clear:
        from contbed.compiled import cache

        folder, size = cache.clear()
        print(f"removed {size / 1e6:.0f} MB of compiled code from {folder}")
        return
    from contbed.cli.warm import warm as each

    total = 0.0
    for name, seconds in each():
        print(f"{name}: {seconds:.1f} s", flush=True)
        total += seconds
    print(f"ready after {total:.1f} s of CPU")


@app.command()
def converge(
    scene: SceneFile,
    levels: Annotated[
        int, Option("--levels", metavar="N", min=2, max=12, help="number of meshes")
    ] = 4,
    out: OutFolder = None,
    trust: Trust = False,
    allow_large: AllowLarge = False,
) -> None:
    """Refine the mesh of a scene step by step.

    Prints the difference from the level before, observed order and time of each level.
    """
    from contbed.many.converge import converge as study

    print(
        study(
            scene,
            levels,
            out or Path("results") / f"{scene.stem}-converge",
            trust,
            allow_large,
        )
    )


@app.command()
def bench(
    study: Annotated[Path, Argument(metavar="STUDY", help="a study's folder")],
    out: OutFolder = None,
    trust: Annotated[
        bool, Option("--trust", help="let it run the programs that the study names")
    ] = False,
) -> None:
    """Measure run time against error.

    Runs the programs that a study names.
    """
    from contbed.many.bench import bench as measure

    print(measure(study, out or Path("results") / f"{study.name}-bench", trust))


@app.command()
def report(
    folders: Annotated[
        list[Path],
        Argument(
            metavar="DIR...",
            help="folders of runs, or that of a command that makes many",
        ),
    ],
    out: Annotated[
        Path | None,
        Option(
            "--out", metavar="FILE", help="file to write; report.html in DIR if absent"
        ),
    ] = None,
) -> None:
    """Write one HTML file about runs.

    Also about a sweep, an optimum and the like. The file needs no network and no
    server.
    """
    print(f"the report is {_write_report(folders, out)}")


@app.command()
def validate(
    names: Annotated[
        list[str] | None,
        Argument(metavar="NAME...", help="measured beds; all short ones if absent"),
    ] = None,
    out: OutFolder = None,
    long: Annotated[
        bool, Option("--long", help="those that take more than a minute as well")
    ] = False,
) -> None:
    """Compare the models with measured beds.

    Gives deviation, uncertainty and verdict of each bed, a table and a picture.
    """
    from contbed.many.validate import case, report, score
    from contbed.output.folder import prepare_study

    cases = [case.read_case(name) for name in names or case.names()]
    folder = out or Path("results") / "validation"
    prepare_study(folder, "summary.json", "validation.png")
    chosen = [one for one in cases if names or long or not one.settings.long]
    done = [score.validate(one, folder / one.name) for one in chosen]
    report.write(done, folder)
    print(report.table(done))
    for one in done:
        for text in one.result.warnings:
            complain(f"{one.case.name}: warning: {text}")
    left = [one.name for one in cases if one not in chosen]
    if left:
        complain(
            f"left out, as they take more than a minute: {', '.join(left)}; --long "
            "runs them"
        )
    print(f"results are in {folder}")


for _command in (*studies.COMMANDS, *lookup.COMMANDS):
    app.command(_command.__name__.strip("_"))(_command)


def _write_report(folders: list[Path], file: Path | None = None) -> Path:
    from contbed.report.write import write

    return write(folders, file)


def _require_place(folder: Path) -> None:
    from contbed.report.write import FILE, require_place

    require_place(folder / FILE)


def _tell_when_compiling(scene: Any) -> None:
    from contbed.models import model_of

    if model_of(scene).compiles:
        from contbed.compiled.cache import tell_when_compiling

        tell_when_compiling()
