"""Speed and accuracy of the discrete elements beside LIGGGHTS and LAMMPS."""

from __future__ import annotations

import resource
import tempfile
import time
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.plan import SKIN
from contbed.closures import drag_di_felice
from contbed.compiled import threads
from contbed.dem import heat, heat_pair, network
from contbed.dem.contact import hertz_impact
from contbed.dem.contact_heat import ContactHeat
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, box
from contbed.materials import ConstantFluid
from studies import _gallery as gallery
from studies._gallery import Table, Tables, particle_codes

HERE = Path(__file__).parent
D, STEP, REPEATS = 2e-3, 1e-5, 3
# [m/s], of 2 mm and 2500 kg/m3 by Wen and Yu
AIR, U_MF = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026), 1.1
STEPS = {2500: 6000, 16000: 1200, 100_000: 150}
# width of a tile [d], tiles, density
BEDS = {2500: (13, 1, 1000.0), 16000: (24, 1, 2500.0), 100_000: (10, 10, 2500.0)}
ORDERS = ("packed", "random")  # of the particles in the file
HEATS = ("none", "contacts")
DECKS = {"LIGGGHTS": "liggghts.in", "LAMMPS": "lammps.in"}
OWN = "contbed"
NOT_COMPARED = (
    "particle_steps_per_cpu_s", "times_LIGGGHTS", "cpu_s", "times_contbed", "cpu_s_per_step",
    "wall_s_per_step", "cpu_s_per_step_of_all", "times_faster", "times_by_cpu",
)  # fmt: skip
SKINS = (5e-4, 1e-4)  # of the shared decks, and the default of contbed


def own_seconds(simulation: Simulation, steps: int) -> float:
    """CPU time of some steps [s]."""
    return float(gallery.cpu(lambda: simulation.run(steps), samples=1).seconds)


def least(simulation: Simulation, steps: int) -> float:
    """The least of several."""
    simulation.run(200)
    return min(own_seconds(simulation, steps) for _ in range(REPEATS))


def reference(code: str, folder: Path, steps: int, variables: dict[str, Any]) -> float:
    """CPU time of some steps of a peer [s], of the bed that is in a folder, with
    variables of its deck.
    """
    return particle_codes.seconds(
        code, HERE / DECKS[code], folder, variables, steps, repeats=1
    )


def bed_of(count: int) -> tuple[Any, float, Material]:
    """A settled bed between walls, or tiles of it side by side; centres, width and
    material.
    """
    width, tiles, density = BEDS[count]
    material = Material(density)
    number = count // tiles**2
    cost, bed = gallery.cpu(
        lambda: pack((width * D, width * D), count=number, material=material), samples=1
    )
    print(f"packing of {number}: {cost:.1f} CPU s, {bed.statistics}")
    return _tiled(bed.position, width * D, tiles, tiles), tiles * width * D, material


def speed() -> Table:
    """Particle-steps per CPU second in the same settled bed, all codes with the same
    skins of their neighbour lists.

    The codes run in turn, several times, so that what else the machine does slows all
    of them.
    """
    rows = []
    pack((6 * D, 6 * D), count=50)  # compiles
    for count, steps in STEPS.items():
        packed, side, material = bed_of(count)
        orders = dict(
            zip(
                ORDERS,
                (packed, np.random.default_rng(0).permutation(packed)),
                strict=True,
            )
        )
        domain = Domain((0, 0, 0), (side, side, np.inf))
        for (order, position), heated, skin in product(orders.items(), HEATS, SKINS):
            simulation = Simulation(
                Particles(position, D / 2),
                [material],
                box(domain),
                domain,
                time_step=STEP,
                skin=skin,
                largest_overlap=0.1,
                **(
                    {"heat": ContactHeat(26.0), "T": _warm(position)}
                    if heated == "contacts"
                    else {}
                ),
            )
            simulation.run(200)
            plain = order == "packed" and heated == "none"
            peers = [
                code
                for code in (DECKS if plain else ("LIGGGHTS",))
                if particle_codes.available(code)
            ]
            taken: dict[str, list[float]] = {code: [] for code in (OWN, *peers)}
            variables = {
                "data": "bed.data",
                "L": repr(side),
                "skin": repr(skin),
                "heat": int(heated == "contacts"),
            }
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                particle_codes.write_bed(
                    folder / "bed.data", position, D, side, material.density
                )
                for _ in range(REPEATS):
                    taken[OWN].append(own_seconds(simulation, steps))
                    for code in peers:
                        taken[code].append(
                            particle_codes.seconds(
                                code, HERE / DECKS[code], folder, variables, steps, 1
                            )
                        )
            seconds = {name: min(values) for name, values in taken.items()}
            for name, value in seconds.items():
                ratio = (
                    f"{seconds['LIGGGHTS'] / value:.2f}"
                    if "LIGGGHTS" in seconds
                    else None
                )
                rows.append(
                    (
                        name,
                        count,
                        order,
                        heated,
                        1e3 * skin,
                        count * steps / value,
                        ratio,
                    )
                )
    names = (
        "code",
        "particles",
        "order",
        "heat",
        "skin_mm",
        "particle_steps_per_cpu_s",
        "times_LIGGGHTS",
    )
    return Table(
        dict.fromkeys(names, "g")
        | dict.fromkeys(("code", "order", "heat"), "")
        | {names[5]: ".3g"},
        rows,
    )


def _warm(position: Any) -> Any:
    """Temperatures that fall along x [K]."""
    return 400.0 - 100.0 * position[:, 0] / position[:, 0].max()


def conduction() -> Table:
    """Heat through the contacts of 2500 particles: LIGGGHTS in explicit steps, and the
    network, by the same formula.

    LIGGGHTS 3.8 takes G = 2 k sqrt(pi) a with the radius a of the circle in which the
    spheres intersect. The heat capacity is the smallest of a few at which its steps are
    stable.
    """
    width, _, density = BEDS[2500]
    width *= D
    bed = pack((width, width), count=2500, material=Material(density))
    low, high, k, steps = 2e-3, 24.7e-3, 26.0, 20000
    z = bed.position[:, 2]
    hot, cold = z < low, z > high

    def conducted() -> float:
        pairs = heat.near_pairs(bed.position, D)
        circle = np.sqrt(
            np.maximum(0.25 * (D - pairs.distance) * (D + pairs.distance), 0.0)
        )
        parts = {
            "contact": heat_pair.contact_conductance(np.sqrt(np.pi) * circle, k, k)
        }
        return network.between_layers(
            bed.position, pairs, parts, hot, cold, width**2, 125.0, 25.0
        ).heat

    own_cpu, own = gallery.cpu(conducted, samples=5)
    rows: list[tuple[Any, ...]] = [("contbed, network", own, None, own_cpu, None, 1)]
    if particle_codes.available("LIGGGHTS"):
        variables = {"data": "bed.data", "kp": k, "cp": 0.07, "zl": low, "zh": high}
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            particle_codes.write_bed(
                folder / "bed.data", bed.position, D, width, density, hot | cold
            )
            deck = HERE / "liggghts_etc.in"
            cost = particle_codes.seconds(
                "LIGGGHTS", deck, folder, variables, steps, REPEATS
            )
            words = (
                line.split() for line in (folder / "printed").read_text().splitlines()
            )
        table = np.array(
            [
                [float(w) for w in row]
                for row in words
                if len(row) == 4 and row[1] == "2500"
            ]
        )
        near = np.abs(np.abs(table[:, 2:]) / own - 1.0).max(axis=1) < 1e-3
        for count in (int(table[near][0, 0]), steps):
            value, cpu = table[table[:, 0] == count][-1, 3], cost * count / steps
            rows.append(
                (
                    "LIGGGHTS, explicit",
                    value,
                    value / own - 1,
                    cpu,
                    count,
                    cpu / own_cpu,
                )
            )
    columns = {
        "code": "",
        "heat_W": ".7g",
        "difference": ".1e",
        "cpu_s": ".3g",
        "steps": "d",
        "times_contbed": ".0f",
    }
    return Table(columns, rows)


def accuracy() -> Table:
    """Error of the largest overlap and of the speed after a head-on impact, e = 1
    and 0.9.
    """
    rows, radius, speed = [], D / 2, 0.1
    for steps in (20, 40, 80, 160, 320, 640):
        row: dict[str, object] = {"steps_per_impact": steps}
        for restitution in (1.0, 0.9):
            material = Material(restitution=restitution)
            mass = 2.0 / 3.0 * np.pi * radius**3 * material.density
            duration, deepest = hertz_impact(
                mass, radius / 2, pair_table([material])["youngs_modulus"][0, 0], speed
            )
            worst_speed, worst_overlap = 0.0, 0.0
            # where in a step the spheres meet
            for phase in np.linspace(0.0, 1.0, 8, endpoint=False):
                gap = (1.0 + phase) * speed * duration / steps
                spheres = Particles(
                    [[0, 0, 0], [2 * radius + gap, 0, 0]],
                    radius,
                    velocity=[[speed, 0, 0], [0, 0, 0]],
                )
                pair = Simulation(
                    spheres, [material], gravity=(0, 0, 0), time_step=duration / steps
                )
                overlap = 0.0
                for _ in range(round(1.3 * steps) + 4):
                    pair.run(1)
                    overlap = max(overlap, *pair.contacts().overlap, 0.0)
                after = float(np.diff(pair.velocity[:, 0])[0])
                worst_speed = max(worst_speed, abs(after / (restitution * speed) - 1.0))
                worst_overlap = max(worst_overlap, abs(overlap / deepest - 1.0))
            row[f"speed_error_e_{restitution:g}"] = f"{worst_speed:.2e}"
            if restitution == 1.0:
                row["overlap_error"] = f"{worst_overlap:.2e}"
        rows.append(row)
    return Table.of(rows)


def scaling() -> Table:
    """A settled bed with periodic sides, repeated."""
    rows, width = [], 10 * D
    bed = pack((width, width), count=1000, periodic=(True, True))
    for times in (1, 2, 4, 7, 10, 32):
        position = _tiled(bed.position, width, times, times)
        domain = Domain(
            (0, 0, 0), (times * width, times * width, np.inf), (True, True, False)
        )
        simulation = Simulation(
            Particles(position, D / 2),
            [bed.material],
            box(domain),
            domain,
            time_step=STEP,
            largest_overlap=0.1,
        )
        steps = max(100, 4_000_000 // len(position))
        value = least(simulation, steps) / steps
        rows.append((len(position), value, len(position) / value))
    return Table(
        {"particles": "d", "cpu_s_per_step": ".3g", "particle_steps_per_cpu_s": ".3g"},
        rows,
    )


def several_threads() -> Table:
    """Two beds of 50 000 particles in random order on one and two threads, in turn from
    one state; the least of each.

    One alone, one in gas, as it is fluidized, with lists as in scenes. `times_faster`
    compares times on the clock and needs two quiet cores. `times_by_cpu` is the number
    of threads times the CPU of one over that of all, with their waiting for each other:
    what cores that are free would give.
    """
    alone, gas = _bed_alone(), bed_in_gas(skin=SKIN * D / 2)
    runs: dict[str, tuple[Any, Any, int]] = {
        "alone": (alone, lambda: alone.run(40), 40),
        "in gas": (gas, lambda: gas.run(4e-3), round(4e-3 / gas.simulation.time_step)),
    }
    rows: list[tuple[Any, ...]] = []
    for name, (bed, run, steps) in runs.items():
        with threads.using(1):
            run()
        state = bed.state()
        clock: dict[int, list[float]] = {1: [], 2: []}
        cpu: dict[int, list[float]] = {1: [], 2: []}
        for _ in range(2 * REPEATS):
            for number in clock:
                bed.restore(state)
                before, start = (
                    resource.getrusage(resource.RUSAGE_SELF),
                    time.perf_counter(),
                )
                with threads.using(number):
                    run()
                clock[number].append((time.perf_counter() - start) / steps)
                after = resource.getrusage(resource.RUSAGE_SELF)
                cpu[number].append(
                    (
                        after.ru_utime
                        + after.ru_stime
                        - before.ru_utime
                        - before.ru_stime
                    )
                    / steps
                )
        rows += [
            (name, 50_000, number, min(clock[number]), min(cpu[number]), min(clock[1]) / min(clock[number]),
             number * min(cpu[1]) / min(cpu[number]))
            for number in clock
        ]  # fmt: skip
    return Table(
        {"bed": "", "particles": "d", "threads": "d"}
        | dict.fromkeys(("wall_s_per_step", "cpu_s_per_step_of_all"), ".3g")
        | dict.fromkeys(("times_faster", "times_by_cpu"), ".2f"),
        rows,
    )


def _bed_alone() -> Simulation:
    """A settled bed of 50 000 particles in random order."""
    width = 10 * D
    bed = pack((width, width), count=1000, periodic=(True, True))
    position = np.random.default_rng(0).permutation(_tiled(bed.position, width, 10, 5))
    domain = Domain((0, 0, 0), (10 * width, 5 * width, np.inf), (True, True, False))
    spheres = Particles(position, D / 2)
    return Simulation(
        spheres,
        [bed.material],
        box(domain),
        domain,
        time_step=STEP,
        largest_overlap=0.1,
    )


def bed_in_gas(engine: Any = OWN, skin: float | None = None) -> Bed:
    """A bed of 50 000 particles in random order, in air at three times the speed at
    which they begin to lift.
    """
    pitch, count = 1.02 * D, (50, 25, 40)
    places = (
        np.stack(
            np.meshgrid(*(np.arange(n) + 0.5 for n in count), indexing="ij"), -1
        ).reshape(-1, 3)
        * pitch
    )
    rng = np.random.default_rng(0)
    places = rng.permutation(places) + rng.uniform(-0.005, 0.005, places.shape) * D
    sides = pitch * np.array(count[:2])
    domain = Domain((0, 0, 0), (*sides, np.inf))
    material = Material(2500.0, 1e6, restitution=0.9, sliding_friction=0.3)
    spheres = Particles(places, D / 2)
    simulation = Simulation(
        spheres,
        [material],
        box(domain),
        domain,
        impact_speed=0.3,
        skin=skin,
        engine=engine,
    )
    cells = (17, 8, 40)
    size = np.array([*sides, 3 * count[2] * pitch]) / cells
    gas = Gas(Grid(np.zeros(3), size, cells, (False, False)), AIR, drag_di_felice)
    gas.inlet(3.0 * U_MF, 300.0)
    return Bed(simulation, gas, 5e-4)


def _tiled(position: Any, width: float, x: int, y: int) -> Any:
    """Centres of a bed that is repeated along x and y."""
    cells = np.stack(
        np.meshgrid(range(x), range(y), [0], indexing="ij"), axis=-1
    ).reshape(-1, 1, 3)
    return (cells * width + position).reshape(-1, 3)


def compute() -> Tables:
    """Speed, conduction, accuracy and scaling; the committed rows of peers are kept
    where they are not installed.
    """
    kept = {
        "speed": ("code", "particles", "order", "heat", "skin_mm"),
        "conduction": ("code",),
    }
    found = {
        "speed": speed(),
        "conduction": conduction(),
        "accuracy": accuracy(),
        "scaling": scaling(),
    }
    found["threads"] = several_threads()
    return gallery.updated(HERE, found, kept)


def plot(tables: Tables) -> dict[str, Any]:
    """Speed over that of LIGGGHTS, error of an impact, CPU over the number of
    particles.
    """
    figure, (left, middle, right) = gallery.figure(1, 3)
    fast, error, size = tables["speed"], tables["accuracy"], tables["scaling"]
    for (order, heated), style in zip(
        product(ORDERS, HEATS), ("o-", "o--", "s-", "s--"), strict=True
    ):
        row = {
            "code": OWN,
            "order": order,
            "heat": heated,
            "skin_mm": f"{1e3 * SKINS[0]:g}",
        }
        found = fast.where(row)
        text = "as packed" if order == "packed" else "random order"
        label = text + (", heat" if heated == "contacts" else "")
        left.semilogx(found["particles"], found["times_LIGGGHTS"], style, label=label)
    left.axhline(1.0, color="k", lw=0.8)
    left.set(
        xlabel="particles",
        ylabel="speed over that of LIGGGHTS",
        ylim=(0.0, None),
        title="settled bed, one core",
    )
    for key, text in (
        ("overlap_error", "largest overlap, e = 1"),
        ("speed_error_e_1", "speed after, e = 1"),
        ("speed_error_e_0.9", "speed after, e = 0.9"),
    ):
        middle.loglog(error["steps_per_impact"], error[key], "o-", label=text)
    gallery.ticks(middle, x=error["steps_per_impact"])
    middle.set(
        xlabel="steps in an impact",
        ylabel="relative error",
        title="one impact against Hertz",
    )
    count, cpu = size["particles"], 1e3 * size["cpu_s_per_step"]
    right.loglog(count, cpu, "o-", label="measured")
    right.loglog(count, cpu[0] * count / count[0], "k--", label="proportional")
    right.set(
        xlabel="particles", ylabel="CPU of a step [ms]", title="run time against number"
    )
    for axes in (left, middle, right):
        axes.legend()
    return {"dem_speed": figure}
