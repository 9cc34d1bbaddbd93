"""Particles on a GPU beside one core: time of a step, and how far the two are apart."""

from __future__ import annotations

import time
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import contbed
from contbed.cfd_dem.coupling import Bed
from contbed.compiled import threads
from contbed.dem.contact_heat import ContactHeat
from contbed.dem.gpu import require_gpu
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, box
from contbed.errors import EngineError
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
D, STEP = 2e-3, 1e-5
WIDTH, COUNT = 10 * D, 1000  # of the bed that is repeated
TILES = (1, 4, 10, 32, 64)
# on the GPU, on one core
STEPS = {1: (1000, 1000), 4: (400, 400), 10: (200, 200), 32: (200, 40), 64: (200, 0)}
# m/s, root mean square of each component of the velocity at the start
STATES = {"at rest": 0.0, "moving": 0.1}
HEATS = ("none", "contacts")
NOT_COMPARED = (
    "gpu_ms_per_step", "gpu_ns", "core_ns", "times_faster", "apart", "wall_s", "times_cuda", "settling_s", "network_s",
    "balance",
)  # fmt: skip
COLUMNS = {
    "particles": "d", "state": "", "heat": "", "gpu_ms_per_step": ".3g", "gpu_ns": ".3g", "core_ns": ".3g",
    "times_faster": ".0f", "apart": ".1e",
}  # fmt: skip


def bed(start: Any, tiles: int, state: str, heated: str, engine: Any) -> Simulation:
    """A settled bed with periodic sides, repeated; its particles at rest, or each
    with a velocity of its own.
    """
    cells = np.stack(
        np.meshgrid(range(tiles), range(tiles), [0], indexing="ij"), axis=-1
    ).reshape(-1, 1, 3)
    position = (cells * WIDTH + start).reshape(-1, 3)
    velocity = np.random.default_rng(0).normal(0.0, 1.0, position.shape) * STATES[state]
    domain = Domain(
        (0, 0, 0), (tiles * WIDTH, tiles * WIDTH, np.inf), (True, True, False)
    )
    warm: dict[str, Any] = {}
    if heated == "contacts":
        warm = {
            "heat": ContactHeat(26.0),
            "T": 400.0 - 100.0 * position[:, 0] / position[:, 0].max(),
        }
    spheres = Particles(position, D / 2, velocity=velocity)
    return Simulation(
        spheres,
        [Material()],
        box(domain),
        domain,
        time_step=STEP,
        largest_overlap=0.1,
        engine=engine,
        **warm,
    )


def seconds(simulation: Simulation, steps: int) -> float:
    """Time on the clock of an interval [s], with what goes in and out."""
    start = time.perf_counter()
    simulation.advance(steps)
    return time.perf_counter() - start


def reference(
    start: Any, tiles: int, state: str, heated: str, steps: int
) -> tuple[float, Simulation]:
    """Time of a step on one core [s], and the bed afterwards."""
    own = bed(start, tiles, state, heated, "contbed")
    return seconds(own, steps) / steps, own


def speed() -> Table:
    """One row for each size, state and with heat or without."""
    rows: list[tuple[Any, ...]] = []
    start = pack((WIDTH, WIDTH), count=COUNT, periodic=(True, True)).position
    for heated in HEATS:  # compiles
        for engine in ("contbed", "cuda"):
            bed(start, 1, "moving", heated, engine).advance(40)
    for tiles, state, heated in product(TILES, STATES, HEATS):
        on_gpu, on_core = STEPS[tiles]
        number = tiles**2 * COUNT
        fast = seconds(bed(start, tiles, state, heated, "cuda"), on_gpu) / on_gpu
        slow = apart = None
        if on_core:
            slow, own = reference(start, tiles, state, heated, on_core)
            again = bed(start, tiles, state, heated, "cuda")
            again.advance(on_core)
            apart = float(np.abs(again.position - own.position).max()) / D
        row = (
            number,
            state,
            heated,
            1e3 * fast,
            1e9 * fast / number,
            None if slow is None else 1e9 * slow / number,
        )
        rows.append((*row, None if slow is None else slow / fast, apart))
        print(rows[-1], flush=True)
    return Table(COLUMNS, rows)


def in_gas() -> Table:
    """A fluidized bed of 50,000 particles, whose gas is computed by one core in both
    runs.
    """
    from studies.dem_speed.study import bed_in_gas

    rows, found = [], {}
    for engine in ("cuda", "contbed"):
        fluidized: Bed = bed_in_gas(engine)
        fluidized.run(1e-3)
        start = time.perf_counter()
        fluidized.run(4e-3)
        found[engine] = time.perf_counter() - start
        rows.append(
            (
                engine,
                len(fluidized.simulation.position),
                found[engine],
                found[engine] / found["cuda"],
            )
        )
    return Table(
        {"particles_on": "", "particles": "d", "wall_s": ".3g", "times_cuda": ".2f"},
        rows,
    )


def million() -> Table:
    """A million spheres that settle from a random start, and the network of their
    conductances.
    """
    result = contbed.run(contbed.load(HERE / "million.toml"), engine="cuda")
    columns = {
        "spheres": "d", "settling_s": ".3g", "network_s": ".3g", "porosity": ".4f", "coordination": ".3f",
        "k_eff_W_mK": ".4f", "balance": ".1e",
    }  # fmt: skip
    row = [
        result.plan.unknowns()["heat"],
        result.timings["packing"],
        result.timings["heat"],
    ]
    row += [result.qoi[name] for name in ("porosity", "coordination", "k_eff [W/m/K]")]
    return Table(columns, [(*row, result.balances["energy"]["relative_residual"])])


def compute() -> Tables:
    """The tables; those that are committed where there is no GPU."""
    try:
        require_gpu()
    except EngineError as error:
        print(f"the committed tables are kept: {error}")
        return {
            name: Table.read(HERE / f"{name}.csv")
            for name in ("speed", "gas", "million")
        }
    with threads.using(1):
        return {"speed": speed(), "gas": in_gas(), "million": million()}


def plot(tables: Tables) -> dict[str, Any]:
    """Time of a particle and step over the number of particles."""
    figure, axes = gallery.figure()
    for (state, heated), color in zip(
        product(STATES, HEATS), ("C0", "C1", "C2", "C3"), strict=True
    ):
        found = tables["speed"].where({"state": state, "heat": heated})
        text = state + (", heat" if heated == "contacts" else "")
        axes.loglog(found["particles"], found["gpu_ns"], "o-", color=color, label=text)
        axes.loglog(found["particles"], found["core_ns"], "s--", color=color)
    axes.set(
        xlabel="particles",
        ylabel="time of a particle and step [ns]",
        title="GPU, and dashed: one core",
    )
    axes.legend(loc="lower left")
    return {"dem_gpu": figure}
