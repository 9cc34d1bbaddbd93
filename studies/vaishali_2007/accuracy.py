"""Error of the mean profiles of the riser against CPU, contbed beside OpenFOAM's
twoPhaseEulerFoam.

Both programs run `ff_wenyu.toml`, warm, on 15x350 cells over Courant numbers, and on
30x700 for a reference of their own (minutes to half an hour of CPU each). Profiles are
means over time and over the height of the measurements, in blocks of time, whose
scatter says what a difference means. CPU is that of the time that is averaged, one
thread. A case is PROGRAM,CELLS,COURANT such as contbed,15x350,0.5; the blocks of the
others are kept.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.two_fluid.averages import Averages, along
from contbed.two_fluid.results import tables as tables_of
from studies import _gallery as gallery
from studies._gallery import Table, Tables, openfoam

HERE = Path(__file__).parent
OWN, PEER = "contbed", openfoam.SOLVER
COARSE, FINE, WIDER = "15x350", "30x700", "30x350"
ACROSS = 15  # cells on which profiles are compared
SCENE = HERE / "ff_wenyu.toml"
BLOCK = 2.5  # [s]
# each code starts near the holdup that it will have: fraction, end of the start and of
# the averages [s]
STARTS = {OWN: (0.0165, 10.0, 30.0), PEER: (0.00521569, 5.0, 15.0)}
REFERENCE = {OWN: 0.5, PEER: 1.0}  # Courant number on the fine grid
BLOCKS = {"program": "", "cells": "", "courant": "g", "block": "d", "steps": "d"}
BLOCKS |= dict.fromkeys(("cpu_s", "x", "eps_s", "u_solid"), ".4g")
RUN = ("program", "cells", "courant")
# of the axes: CPU a simulated second [s], error
TICKS, ERRORS = (1, 2, 5, 10, 20), (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
QUANTITIES = {"eps_s": "eps_s [1]", "u_solid": "u_solid [m/s]"}
# steps, CPU [s], eps_s and u_solid over the width
Block = tuple[int, float, np.ndarray]


def numbers(cells: str) -> list[int]:
    """Cells across and along the riser."""
    return [int(number) for number in cells.split("x")]


def scene(cells: str, courant: float) -> cb.Scene:
    fraction, begin, end = STARTS[OWN]
    chosen = {
        "mesh.cells": numbers(cells),
        "initial.solids.beads.volume_fraction": fraction,
    }
    return cb.load(
        SCENE,
        {
            **chosen,
            "time.courant": courant,
            "time.end": end,
            "time.average_from": begin,
        },
    )


def own(cells: str, courant: float, found: Tables) -> Iterator[Block]:
    """Blocks of contbed; on the fine grid also the lateral profile of all of them,
    into `found`.
    """
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

        steps, clock = bed.state.steps, gallery.user_time()
        bed.advance(stop, after)
        cpu, sums = (
            gallery.user_time() - clock,
            dict(zip(QUANTITIES, total[:, inside], strict=True)),
        )
        means = along(x[inside], volume[inside], sums, {}, numbers(cells)[0])[1]
        yield (
            bed.state.steps - steps,
            cpu,
            np.array([means[name] for name in QUANTITIES]) / BLOCK,
        )
    if averages is not None:
        lateral = tables_of(plan, bed, averages, {"t [s]": np.zeros(0)})["lateral"]
        found["ff_wenyu_fine_lateral"] = Table.from_columns(lateral, ".5g")


def reference(cells: str, courant: float) -> Iterator[Block]:
    """Blocks of the peer."""
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
        start=(fraction, chosen.initial.gas.velocity, chosen.initial.solid.velocity),
        write_every=BLOCK,
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        openfoam.run(case, folder)
        yield from blocks(case, folder)


def blocks(case: openfoam.Case, folder: Path) -> Iterator[Block]:
    """Means of each block, from those since the start of the averages that the peer
    writes.
    """
    log = (folder / f"log.{openfoam.SOLVER}").read_text()
    clock = np.array(
        re.findall(r"^Time = ([0-9.]+).*?^ExecutionTime = ([0-9.]+)", log, re.M | re.S),
        float,
    )
    height = (np.arange(case.ny) + 0.5) * case.size[1] / case.ny
    low, high = window(cb.load(SCENE))
    inside = (height > low) & (height < high)
    total, then = np.zeros((2, case.nx)), case.average_from
    for at, path in enumerate(openfoam.times(folder)):
        now = float(path.name)
        if now <= case.average_from:
            continue
        means = (
            openfoam.field(case, folder, f"{name}.particlesMean", at)
            for name in ("alpha", "U")
        )
        eps_s, u_solid = (mean[inside].mean(axis=0) for mean in means)
        grown = (now - case.average_from) * np.array([eps_s, u_solid[:, 1]])
        steps = (clock[:, 0] > then * (1 + 1e-9)) & (clock[:, 0] <= now * (1 + 1e-9))
        cpu = np.ptp(np.interp([then, now], *clock.T))
        yield int(steps.sum()), float(cpu), (grown - total) / (now - then)
        total, then = grown, now


def window(chosen: cb.Scene) -> tuple[float, float]:
    """Height of the measurements [m]."""
    return chosen.output.window.start, chosen.output.window.end


def compute(cases: Sequence[str] = ()) -> Tables:
    """Runs that are named, and the errors of all."""
    tables: Tables = {"accuracy_blocks": Table.read(HERE / "accuracy_blocks.csv")}
    for case in cases:
        program, cells, number = case.split(",")
        courant, rows = float(number), []
        blocks_of = (
            own(cells, courant, tables) if program == OWN else reference(cells, courant)
        )
        for block, (steps, cpu, profile) in enumerate(blocks_of):
            x = (np.arange(profile.shape[1]) + 0.5) / numbers(cells)[0]
            rows += [
                (program, cells, courant, block, steps, cpu, *row)
                for row in zip(x, *profile, strict=True)
            ]
            print(program, cells, courant, block, steps, f"{cpu:.4g}", flush=True)
        tables["accuracy_blocks"] = tables["accuracy_blocks"].updated(
            Table(BLOCKS, rows), RUN
        )
    return tables | {"accuracy": errors(read(tables["accuracy_blocks"]))}


def read(table: Table) -> dict[tuple[str, str, float], tuple[int, float, np.ndarray]]:
    """Steps, CPU a simulated second and profiles (blocks, eps_s and u_solid, width) of
    each run, the width halved, as the riser is symmetric: a mean that is lopsided has
    not been taken for long enough.
    """
    found = {}
    for program, cells, courant in sorted(
        {(row["program"], row["cells"], float(row["courant"])) for row in table}
    ):
        mine = table.where({"program": program, "cells": cells, "courant": courant})
        across = numbers(cells)[0]
        values = np.stack([mine[name] for name in QUANTITIES], axis=1)
        values = (
            values.reshape(-1, ACROSS, across // ACROSS, 2).mean(axis=2).swapaxes(1, 2)
        )
        steps, cpu = mine["steps"][::across], mine["cpu_s"][::across]
        found[program, cells, courant] = (
            int(steps.sum()),
            cpu.mean() / BLOCK,
            (values + values[..., ::-1]) / 2,
        )
    return found


def of(
    runs: dict, program: str, cells: str
) -> dict[float, tuple[int, float, np.ndarray]]:
    """The runs of a program on a grid, by Courant number."""
    return {
        courant: run
        for (*which, courant), run in runs.items()
        if which == [program, cells]
    }


def compare(profile: np.ndarray, reference: np.ndarray) -> list[float]:
    """Relative L1 distance of the means, and the one that the scatter of the blocks
    alone leads to, of eps_s and of u_solid.
    """
    scale = np.abs(reference.mean(axis=0)).sum(axis=1)
    error = np.abs(profile.mean(axis=0) - reference.mean(axis=0)).sum(axis=1) / scale
    variance = sum(
        blocks.var(axis=0, ddof=1) / len(blocks) for blocks in (profile, reference)
    )
    scatter = np.sqrt(2.0 / np.pi * variance).sum(axis=1) / scale
    return [float(value) for pair in zip(error, scatter, strict=True) for value in pair]


def errors(runs: dict[Any, Any]) -> Table:
    """Error and scatter of all runs, and the references."""
    rows: list[tuple[Any, ...]] = []
    for program in (OWN, PEER):
        *finest, exact = runs[program, FINE, REFERENCE[program]]
        for cells in (COARSE, WIDER):
            for courant, (steps, cpu, profile) in of(runs, program, cells).items():
                rows.append(
                    (program, cells, courant, steps, cpu, *compare(profile, exact))
                )
        rows.append((program, FINE, REFERENCE[program], *finest, *[float("nan")] * 4))
    head = (
        *RUN,
        "steps",
        "cpu_per_s",
        *(f"{what}_{name}" for name in QUANTITIES for what in ("error", "scatter")),
    )
    return Table(dict.fromkeys(head, ".5g") | {"steps": "d"}, rows)


def plot(tables: Tables) -> dict[str, Any]:
    """Error of both quantities over CPU, and their profiles."""
    figure, axes = gallery.figure(2, 2, size=(9, 7))
    x, runs = (np.arange(ACROSS) + 0.5) / ACROSS, read(tables["accuracy_blocks"])
    for program, colour in ((OWN, gallery.BLUE), (PEER, gallery.VERMILION)):
        for cells, mark in ((COARSE, "o-"), (WIDER, "s-")):
            found = tables["accuracy"].where({"program": program, "cells": cells})
            for panel, name in zip(axes[0], QUANTITIES, strict=True):
                cpu, error = found["cpu_per_s"], found[f"error_{name}"]
                panel.loglog(
                    cpu,
                    error,
                    mark,
                    color=colour,
                    label=f"{program}, {cells}" if len(found) else None,
                )
                panel.loglog(
                    cpu,
                    found[f"scatter_{name}"],
                    mark[0] + ":",
                    color=colour,
                    mfc="none",
                    alpha=0.6,
                )
                for courant, *point in zip(found["courant"], cpu, error, strict=True):
                    gallery.label_line(panel, f"{courant:g}", *point, "black", (4, 4))
        mine = of(runs, program, COARSE)
        for k, panel in enumerate(axes[1]):
            exact = runs[program, FINE, REFERENCE[program]][2].mean(axis=0)
            panel.plot(x, exact[k], color=colour, label=f"{program}, {FINE}")
            for courant, style in ((0.5, "--"), (max(mine), ":")):
                label = f"{program}, {COARSE}, Courant {courant:g}"
                panel.plot(
                    x,
                    mine[courant][2].mean(axis=0)[k],
                    style,
                    color=colour,
                    label=label,
                )
    for (top, bottom), (name, label) in zip(axes.T, QUANTITIES.items(), strict=True):
        top.set(
            xlabel="CPU a simulated second [s]; numbers: Courant",
            ylabel=f"L1 error of {name}, relative [1]",
        )
        top.set(xlim=(TICKS[0], TICKS[-1]), ylim=(ERRORS[0], ERRORS[-1]))
        gallery.ticks(top, x=TICKS, y=ERRORS)
        bottom.set(xlabel="x / width [1]", ylabel=label)
    axes[0, 0].legend(loc="lower right")
    axes[1, 0].legend()
    return {"accuracy": figure}
