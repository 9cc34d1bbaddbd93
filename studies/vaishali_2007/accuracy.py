"""Error of the mean profiles of the riser against CPU, contbed beside OpenFOAM's twoPhaseEulerFoam.

    python accuracy.py PROGRAM CELLS COURANT    one run on such as 15x350 cells, its blocks added to accuracy_blocks.csv
    python accuracy.py                          accuracy.csv and accuracy.png from all runs there

Both programs run `ff_wenyu.toml`, warm, on 15x350 cells over Courant numbers, and on 30x700 for a reference of their
own (minutes to half an hour of CPU each). Profiles are means over time and over the height of the measurements, in
blocks of time, whose scatter says what a difference means. CPU is that of the time that is averaged, one thread. The
run of contbed on 30x700 also writes ff_wenyu_fine_lateral.csv.
"""

from __future__ import annotations

import csv
import re
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.two_fluid.averages import Averages, along
from contbed.two_fluid.results import tables

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "two_fluid_speed"))
import openfoam  # noqa: E402

OWN, PEER = "contbed", openfoam.SOLVER
COARSE, FINE, WIDER = "15x350", "30x700", "30x350"
ACROSS = 15  # cells on which profiles are compared
SCENE = HERE / "ff_wenyu.toml"
BLOCK = 2.5  # [s]
# each code starts near the holdup that it will have: fraction, end of the start and of the averages [s]
STARTS = {OWN: (0.0165, 10.0, 30.0), PEER: (0.00521569, 5.0, 15.0)}
REFERENCE = {OWN: 0.5, PEER: 1.0}  # Courant number on the fine grid
COLUMNS = ("program", "cells", "courant", "block", "steps", "cpu_s", "x", "eps_s", "u_solid")
TICKS, ERRORS = (2, 3, 5, 10, 20), (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)  # of the axes: CPU a simulated second [s], error
QUANTITIES = {"eps_s": "eps_s [1]", "u_solid": "u_solid [m/s]"}
Block = tuple[int, float, np.ndarray]  # steps, CPU [s], eps_s and u_solid over the width


def numbers(cells: str) -> list[int]:
    """Cells across and along the riser."""
    return [int(number) for number in cells.split("x")]


def scene(cells: str, courant: float) -> cb.Scene:
    fraction, begin, end = STARTS[OWN]
    chosen = {"mesh.cells": numbers(cells), "initial.eps_s": fraction}
    return cb.load(SCENE, {**chosen, "time.courant": courant, "time.end": end, "time.average_from": begin})


def own(cells: str, courant: float) -> Iterator[Block]:
    _, begin, end = STARTS[OWN]
    plan = cb.plan(scene(cells, courant))
    chosen = plan.scene
    bed = plan.bed()[0]
    (x, height), volume = bed.model.grid.centres.T, bed.model.grid.geometry.volume
    low, high = window(chosen)
    inside = (height > low) & (height < high)
    averages = Averages(begin, end) if cells == FINE else None
    bed.advance(begin)
    for stop in np.arange(begin + BLOCK, end + BLOCK / 2, BLOCK):
        total = np.zeros((2, len(x)))

        def after(bed, total=total):
            if averages is not None:
                averages.add(bed)
            total += bed.state.dt * np.array([bed.state.eps_s, bed.state.u_solid[:, 1]])

        steps, clock = bed.state.steps, time.process_time()
        bed.advance(stop, after)
        cpu, sums = time.process_time() - clock, dict(zip(QUANTITIES, total[:, inside], strict=True))
        means = along(x[inside], volume[inside], sums, {}, numbers(cells)[0])[1]
        yield bed.state.steps - steps, cpu, np.array([means[name] for name in QUANTITIES]) / BLOCK
    if averages is not None:
        lateral = tables(plan, bed, averages, {"t [s]": np.zeros(0)})["lateral"]
        write(HERE / "ff_wenyu_fine_lateral.csv", list(lateral), zip(*lateral.values(), strict=True))


def peer(cells: str, courant: float) -> Iterator[Block]:
    fraction, begin, end = STARTS[PEER]
    chosen = cb.load(SCENE)
    case = openfoam.Case(
        "riser",
        *numbers(cells),
        end,
        3.2,
        solids=26.6,
        courant=courant,
        walls="jj",
        largest_dt=0.05,
        average_from=begin,
        start=(fraction, chosen.initial.u_gas, chosen.initial.u_solid),
        write_every=BLOCK,
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        openfoam.run(case, folder)
        yield from blocks(case, folder)


def blocks(case: openfoam.Case, folder: Path) -> Iterator[Block]:
    """Means of each block, from those since the start of the averages that the peer writes."""
    log = (folder / f"log.{openfoam.SOLVER}").read_text()
    clock = np.array(re.findall(r"^Time = ([0-9.]+).*?^ExecutionTime = ([0-9.]+)", log, re.M | re.S), float)
    height = (np.arange(case.ny) + 0.5) * case.size[1] / case.ny
    low, high = window(cb.load(SCENE))
    inside = (height > low) & (height < high)
    total, then = np.zeros((2, case.nx)), case.average_from
    for at, path in enumerate(openfoam.times(folder)):
        now = float(path.name)
        if now <= case.average_from:
            continue
        means = (openfoam.field(case, folder, f"{name}.particlesMean", at) for name in ("alpha", "U"))
        eps_s, u_solid = (mean[inside].mean(axis=0) for mean in means)
        grown = (now - case.average_from) * np.array([eps_s, u_solid[:, 1]])
        steps = (clock[:, 0] > then * (1 + 1e-9)) & (clock[:, 0] <= now * (1 + 1e-9))
        cpu = np.ptp(np.interp([then, now], *clock.T))
        yield int(steps.sum()), float(cpu), (grown - total) / (now - then)
        total, then = grown, now


def window(chosen: cb.Scene) -> tuple[float, float]:
    """Height of the measurements [m]."""
    return chosen.output.window.start, chosen.output.window.end


def write(path: Path, head: list[str], rows) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows([f"{v:.5g}" if isinstance(v, float) else v for v in row] for row in rows)


def run(program: str, cells: str, courant: float) -> None:
    """One run; each block is kept as it comes."""
    path = HERE / "accuracy_blocks.csv"
    if not path.exists():
        write(path, list(COLUMNS), [])
    for number, (steps, cpu, profile) in enumerate({OWN: own, PEER: peer}[program](cells, courant)):
        with open(path, "a", encoding="utf-8") as file:
            for i, (eps_s, u_solid) in enumerate(profile.T):
                label = f"{program},{cells},{courant:g},{number},{steps},{cpu:.4g},{(i + 0.5) / numbers(cells)[0]:.4g}"
                print(f"{label},{eps_s:.4g},{u_solid:.4g}", file=file)
        print(program, cells, courant, number, steps, f"{cpu:.4g}", flush=True)


def read() -> dict[tuple[str, str, float], tuple[int, float, np.ndarray]]:
    """Steps, CPU a simulated second and profiles (blocks, eps_s and u_solid, width) of each run, the width halved, as
    the riser is symmetric: a mean that is lopsided has not been taken for long enough.
    """
    with open(HERE / "accuracy_blocks.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    found = {}
    for key in sorted({(row["program"], row["cells"], float(row["courant"])) for row in rows}):
        mine = [row for row in rows if (row["program"], row["cells"], float(row["courant"])) == key]
        across = numbers(key[1])[0]
        values = np.array([[float(row[name]) for name in QUANTITIES] for row in mine])
        values = values.reshape(-1, ACROSS, across // ACROSS, 2).mean(axis=2).swapaxes(1, 2)
        first = mine[::across]
        cpu = sum(float(row["cpu_s"]) for row in first) / (BLOCK * len(first))
        found[key] = sum(int(row["steps"]) for row in first), cpu, (values + values[..., ::-1]) / 2
    return found


def of(runs: dict, program: str, cells: str) -> dict[float, tuple[int, float, np.ndarray]]:
    """The runs of a program on a grid, by Courant number."""
    return {courant: run for (*which, courant), run in runs.items() if which == [program, cells]}


def compare(profile: np.ndarray, reference: np.ndarray) -> list[float]:
    """Relative L1 distance of the means, and the one that the scatter of the blocks alone leads to, of eps_s and of
    u_solid.
    """
    scale = np.abs(reference.mean(axis=0)).sum(axis=1)
    error = np.abs(profile.mean(axis=0) - reference.mean(axis=0)).sum(axis=1) / scale
    variance = sum(blocks.var(axis=0, ddof=1) / len(blocks) for blocks in (profile, reference))
    scatter = np.sqrt(2.0 / np.pi * variance).sum(axis=1) / scale
    return [float(value) for pair in zip(error, scatter, strict=True) for value in pair]


def draw() -> None:
    runs = read()
    figure, axes = plt.subplots(2, 2, figsize=(9, 7), layout="constrained")
    x = (np.arange(ACROSS) + 0.5) / ACROSS
    rows: list[tuple] = []
    for program, colour in ((OWN, "#0072B2"), (PEER, "#D55E00")):
        *finest, reference = runs[program, FINE, REFERENCE[program]]
        mine = of(runs, program, COARSE)
        for cells, mark in ((COARSE, "o-"), (WIDER, "s-")):
            measured = of(runs, program, cells).items()
            found = {courant: (cpu, *compare(profile, reference)) for courant, (_, cpu, profile) in measured}
            if not found:
                continue
            rows += [(program, cells, courant, steps, *found[courant]) for courant, (steps, *_) in measured]
            for k, panel in enumerate(axes[0]):
                cpu, error, scatter = np.array([(f[0], *f[1 + 2 * k : 3 + 2 * k]) for f in found.values()]).T
                panel.loglog(cpu, error, mark, color=colour, label=f"{program}, {cells}")
                panel.loglog(cpu, scatter, mark[0] + ":", color=colour, mfc="none", alpha=0.6)
                for courant, *point in zip(found, cpu, error, strict=True):
                    panel.annotate(f"{courant:g}", point, (4, 4), textcoords="offset points", fontsize=8)
        rows.append((program, FINE, REFERENCE[program], *finest, *[float("nan")] * 4))
        for k, panel in enumerate(axes[1]):
            panel.plot(x, reference.mean(axis=0)[k], color=colour, label=f"{program}, {FINE}")
            for courant, style in ((0.5, "--"), (max(mine), ":")):
                label = f"{program}, {COARSE}, Courant {courant:g}"
                panel.plot(x, mine[courant][2].mean(axis=0)[k], style, color=colour, label=label)
    for (top, bottom), name, label in zip(axes.T, *zip(*QUANTITIES.items(), strict=True), strict=True):
        top.set(xlabel="CPU a simulated second [s]; numbers: Courant", ylabel=f"L1 error of {name}, relative [1]")
        top.set(xlim=(TICKS[0], TICKS[-1]), ylim=(ERRORS[0], ERRORS[-1]))
        top.set_xticks(TICKS, labels=[f"{tick:g}" for tick in TICKS])
        top.set_yticks(ERRORS, labels=[f"{tick:g}" for tick in ERRORS])
        top.minorticks_off()
        bottom.set(xlabel="x / width [1]", ylabel=label)
    axes[0, 0].legend(fontsize=8, loc="lower right")
    axes[1, 0].legend(fontsize=8)
    figure.savefig(HERE / "accuracy.png", dpi=120)
    head = [
        "program",
        "cells",
        "courant",
        "steps",
        "cpu_per_s",
        *(f"{a}_{b}" for b in QUANTITIES for a in ("error", "scatter")),
    ]
    write(HERE / "accuracy.csv", head, rows)


if __name__ == "__main__":
    if sys.argv[1:]:
        run(sys.argv[1], sys.argv[2], float(sys.argv[3]))
    else:
        draw()
