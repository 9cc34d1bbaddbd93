"""Run time against error: a study's own programs, measured in one session on one
machine.

    contbed bench studies/two_energy_benchmark --trust

`STUDY/bench/bench.toml` lists the programs, which run only with --trust; all run in the
study's folder with this Python, on one thread.

    repeats = 5                                  # runs of each case of a race
    [curves]                                     # points of run time against error, one program a curve
    error = 1e-4                                 # where the curves are compared
    case = [{name = "...", command = ["bench/line.py", ...], needs = "module"}, ...]
    [[race]]                                     # whole processes with the same result, in turn
    title = "..."
    case = [...]

A program of a curve prints a line {"unknowns": n, "error": e, "seconds": t} for each
point. A race takes the user time of each process from its start to its end and the
median over the repeats. In both, ratios are to the first case. Cases whose module in
`needs` is missing are skipped by name; `{out}` in a command is the folder of the
results.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import statistics
import subprocess
import sys
from dataclasses import dataclass
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pydantic import Field

from contbed.errors import ContbedError, SceneError
from contbed.many.study_file import StudyFile
from contbed.many.tables import aligned, write_rows
from contbed.output.files import write_text
from contbed.output.folder import prepare_study
from contbed.scene.quantities import Positive, Table, Whole

THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
)
HEADERS = ("part", "case", "unknowns", "error", "user_s", "ratio")
Row = tuple[str, str, Any, Any, float, Any]
# what a program of a curve prints of each point
POINT = ("unknowns", "error", "seconds")


class Case(Table):
    """One program."""

    name: str
    """name of the case in tables and plots"""
    command: tuple[str, ...] = Field(min_length=1)
    """arguments of this Python, run in the study's folder"""
    needs: str | None = None
    """module without which the case is skipped"""


class Curves(Table):
    """Points of run time against error, one program a curve."""

    title: str
    """title of the plot"""
    error: Positive
    """where the curves are compared"""
    case: tuple[Case, ...] = Field(min_length=1)
    """cases of the curve of error against time"""


class Race(Table):
    """Whole processes with the same result, in turn."""

    title: str
    """title of the plot"""
    case: tuple[Case, ...] = Field(min_length=1)
    """cases that are timed against each other"""


class Settings(Table):
    """bench.toml."""

    kind: ClassVar[str] = "bench"

    title: str = ""
    """title of the study, shown in plots and reports"""
    repeats: Whole = Field(3, ge=1)
    """runs of each case of a race"""
    curves: Curves | None = None
    """error against time of several cases"""
    race: tuple[Race, ...] = ()
    """cases that are timed against each other"""


@dataclass(frozen=True)
class Bench:
    """What was measured: rows under `HEADERS`, cases that were skipped with their
    reason, the machine.
    """

    rows: tuple[Row, ...]
    skipped: tuple[str, ...]
    machine: str

    def __str__(self) -> str:
        lines = [self.machine]
        for part in dict.fromkeys(row[0] for row in self.rows):
            rows: list[tuple[str, ...]] = [
                ("case", "unknowns", "error", "user [s]", "ratio")
            ]
            for _, case, *numbers in (row for row in self.rows if row[0] == part):
                styles = zip(numbers, ("d", ".2e", ".4g", ".3g"), strict=True)
                texts = (
                    "" if value == "" else format(value, style)
                    for value, style in styles
                )
                rows.append((case, *texts))
            lines += ["", part, *aligned(rows, left=(0,))]
        return "\n".join(lines + [""] * bool(self.skipped) + list(self.skipped))


def bench(study: str | Path, out: str | Path, trust: bool = False) -> Bench:
    """Measure a study; writes bench.txt, bench.csv and bench.png into `out`.

    Parameters
    ----------
    study : its folder
    out : folder for the results
    trust : run the programs that the study names; without it they are only listed, in
        the error

    Raises
    ------
    SceneError : mistakes in bench.toml, or the study is not trusted
    ContbedError : the study has no bench.toml, or one of its programs fails
    """
    study, out = Path(study).resolve(), Path(out).resolve()
    plan = _read(study / "bench" / "bench.toml")
    if not trust:
        raise SceneError(_refusal(study / "bench" / "bench.toml", plan))
    prepare_study(out, "bench.txt", "bench.csv", "bench.png")
    skipped: list[str] = []
    rows: list[Row] = []
    if plan.curves is not None:
        rows += _curves(plan.curves, study, out, skipped)
    for race in plan.race:
        rows += _race(race, plan.repeats, study, out, skipped)
    found = Bench(tuple(rows), tuple(skipped), machine())
    write_text(out / "bench.txt", f"{found}\n")
    write_rows(out / "bench.csv", HEADERS, rows)
    return found


def machine() -> str:
    """Processor, number of cores, versions."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            model = next(
                (
                    line.split(":", 1)[1].strip()
                    for line in lines
                    if line.startswith("model name")
                ),
                model,
            )
    except OSError:
        pass
    parts = [
        f"{name} {metadata.version(name)}"
        for name in ("numpy", "scipy", "scikit-fem", "ngsolve")
        if find_spec(name.replace("scikit-fem", "skfem"))
    ]
    return (
        f"{model}, {os.cpu_count()} cores, one thread; Python "
        f"{platform.python_version()}, {', '.join(parts)}"
    )


def _read(file: Path) -> Settings:
    if not file.is_file():
        raise ContbedError(
            f"{file}: no such file; a study to measure lists its programs there"
        )
    found = StudyFile(file, Settings).settings
    if found.curves is None and not found.race:
        raise SceneError(
            f"{file}:1: nothing to measure; give [curves], or [[race]] tables"
        )
    return found


def _refusal(file: Path, plan: Settings) -> str:
    """Return what to say about programs that are not trusted."""
    curves = () if plan.curves is None else plan.curves.case
    cases = [*curves, *(case for race in plan.race for case in race.case)]
    programs = ", ".join(dict.fromkeys(" ".join(case.command) for case in cases))
    return (
        f"{file}: runs programs: {programs}; look at them, then add --trust, in "
        "Python bench(..., trust=True)"
    )


def _present(cases: tuple[Case, ...], skipped: list[str]) -> list[Case]:
    missing = [
        case
        for case in cases
        if case.needs is not None and find_spec(case.needs) is None
    ]
    skipped += [
        f"skipped: {case.name}: {case.needs} is not installed" for case in missing
    ]
    return [case for case in cases if case not in missing]


def _run(command: tuple[str, ...], study: Path, out: Path) -> tuple[str, float]:
    """Return what a program prints, and the user time [s] of its process."""
    parent = str(Path(__file__).parents[2])
    path = os.pathsep.join(filter(None, (parent, os.environ.get("PYTHONPATH"))))
    environment = os.environ | dict.fromkeys(THREADS, "1") | {"PYTHONPATH": path}
    arguments = [sys.executable, *(part.replace("{out}", str(out)) for part in command)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(
        arguments, cwd=study, env=environment, capture_output=True, text=True
    )
    used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if done.returncode:
        raise ContbedError(
            f"{' '.join(command)} failed: "
            f"{(done.stderr.strip() or 'no message').splitlines()[-1]}"
        )
    return done.stdout, used


def _points(case: Case, study: Path, out: Path) -> list[dict[str, Any]]:
    """Return the points that a program of a curve prints, a line of JSON each."""
    points: list[dict[str, Any]] = []
    for line in _run(case.command, study, out)[0].splitlines():
        try:
            point = json.loads(line)
            points.append({key: point[key] + 0 for key in POINT})
        except (ValueError, TypeError, KeyError):
            what = (
                "a line {"
                + ", ".join(f'"{key}": ...' for key in POINT)
                + "} for each point"
            )
            raise ContbedError(
                f"{' '.join(case.command)} printed {line[:60]!r}; expected {what}"
            ) from None
    if not points:
        raise ContbedError(f"{' '.join(case.command)} printed no point of its curve")
    return points


def _curves(plan: Curves, study: Path, out: Path, skipped: list[str]) -> list[Row]:
    """All points, then the time of each curve at the common error."""
    from contbed.output.plots import error_plot

    curves = {}
    rows: list[Row] = []
    for case in _present(plan.case, skipped):
        points = _points(case, study, out)
        curves[case.name] = (
            [p["seconds"] for p in points],
            [p["error"] for p in points],
        )
        rows += [
            (plan.title, case.name, p["unknowns"], p["error"], p["seconds"], "")
            for p in points
        ]
    error_plot(out / "bench.png", curves, "user time [s]", "largest error", plan.title)
    wanted, first = plan.error, None
    for name, (seconds, errors) in curves.items():
        time, how = time_at(wanted, seconds, errors)
        first = first or time
        rows.append(
            (
                f"at an error of {wanted:g}",
                f"{name}{how}",
                "",
                wanted,
                time,
                time / first,
            )
        )
    return rows


def time_at(
    wanted: float, seconds: list[float], errors: list[float]
) -> tuple[float, str]:
    """User time [s] at an error, from the points around it in logarithms, and a note
    where there are none.
    """
    for k in range(1, len(errors)):
        if errors[k] <= wanted < errors[k - 1]:
            t, e = np.log(seconds[k - 1 : k + 1]), np.log(errors[k - 1 : k + 1])
            return float(
                np.exp(t[0] + (t[1] - t[0]) * (np.log(wanted) - e[0]) / (e[1] - e[0]))
            ), ""
    if errors[0] <= wanted:
        return seconds[0], " (or less)"
    return seconds[-1], f" (not reached: {errors[-1]:.1e})"


def _race(
    plan: Race, repeats: int, study: Path, out: Path, skipped: list[str]
) -> list[Row]:
    cases = _present(plan.case, skipped)
    times: dict[str, list[float]] = {case.name: [] for case in cases}
    for _ in range(repeats):
        for case in cases:
            times[case.name].append(_run(case.command, study, out)[1])
    medians = {name: statistics.median(found) for name, found in times.items()}
    # shorter than the resolution of the clock
    first = next(iter(medians.values()), 0.0) or float("nan")
    return [
        (plan.title, name, "", "", time, time / first) for name, time in medians.items()
    ]
