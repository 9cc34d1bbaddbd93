"""Hot gas injected into a bed at incipient fluidization: Patil, Peters and Kuipers,
Figs 2-6.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.plan import SKIN
from contbed.closures import drag_gidaspow, nusselt_gunn
from contbed.dem.packing import loose_height, pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, box
from contbed.materials import gas_mixture
from contbed.output import checkpoint
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.bubbles import draw_bubbles, equivalent_diameter, largest_bubble
from studies._gallery.raw import raw

HERE = Path(__file__).parent
WIDTH, NOZZLE, DURATION = 0.21, 0.014, 0.18  # of the paper
END = 0.45  # s
FLUX, T_BED = 17.55, 300.0  # kg/m2/s through the nozzle, K
BACKGROUND = {1: 0.65, 2: 1.1, 3: 1.45}  # m/s by diameter in mm
COUNT, DEPTH = 45000, 0.018  # of the paper's bed of 3 mm, which sets the height
GLASS = Material(
    density=2526.0, youngs_modulus=5e6, restitution=0.97, sliding_friction=0.1
)
OPEN = 0.8  # porosity above which a cell belongs to a bubble
EVERY = 0.01  # s, between samples
SHOWN = (0.1, 0.2, 0.3, 0.4)  # s
# of the radius, to which the weight of 28 cm of spheres of 1 mm presses some of them
# together
OVERLAP = 0.15
# diameters of the loose bed; one that falls so far would bounce for long while it
# settles
DEEP = 400.0
# height of the gas over that of the bed: a plug on the bubble rises to more than twice
# of it
ROOM = 3.0
AIR = "N2:0.79, O2:0.21"
CASES = ("half_2mm_300", "half_2mm_900", "half_3mm_300", "half_3mm_600", "half_3mm_900")
COLUMNS = (
    "t [s]",
    "diameter [m]",
    "T_bubble [K]",
    "z_bubble [m]",
    "T_particle_max [K]",
)
STYLES = {1: ":", 2: "--", 3: "-"}  # by diameter in mm
# the last of them that was run is drawn in snapshots.png
PICTURED = ("half_3mm_900", "3mm_900")


class Case:
    """`3mm_700`: width and nozzle of the paper; `half_1mm_900`: width, height, nozzle
    and times halved.

    All are four diameters deep with periodic sides; the paper's beds are 6 to 10 deep,
    between walls.
    """

    def __init__(self, name: str):
        self.name = name
        size, T = name.removeprefix("half_").split("mm_")
        self.d, self.T, self.scale = (
            1e-3 * int(size),
            float(T),
            0.5 if name.startswith("half_") else 1.0,
        )
        self.width, self.nozzle, self.depth = (
            self.scale * WIDTH,
            self.scale * NOZZLE,
            4.0 * self.d,
        )
        self.velocity = BACKGROUND[int(size)]
        self.count = round(
            COUNT * (3e-3 / self.d) ** 3 * self.depth / DEPTH * self.scale**2
        )
        self.skin = SKIN * self.d / 2  # of the lists of neighbours, as in scenes
        self.is_deep = (
            loose_height(np.full(self.count, self.d / 2), self.width * self.depth)
            > DEEP * self.d
        )


def settled(case: Case) -> dict[str, np.ndarray]:
    """Positions and height of the bed, with strong damping: what moves in it later
    is the gas's work.
    """
    damped = replace(GLASS, restitution=0.3)
    packing = pack(
        (case.width, case.depth),
        radius=case.d / 2,
        count=case.count,
        periodic=(False, True),
        material=damped,
        seed=1,
        at_rest=1e-3,
        skin=case.skin if case.is_deep else None,
        kinetic_damping=case.is_deep,
    )
    return {
        "settled": packing.position,
        "height": np.array(packing.statistics["height"]),
    }


def coupled(
    case: Case, packing: Mapping[str, np.ndarray]
) -> tuple[Bed, Callable[[bool], None]]:
    """The bed, and what switches the jet on and off."""
    height = ROOM * float(packing["height"])
    domain = Domain((0, 0, 0), (case.width, case.depth, np.inf), (False, True, False))
    spheres = Particles(packing["settled"], case.d / 2)
    simulation = Simulation(
        spheres,
        [GLASS],
        box(domain),
        domain,
        impact_speed=1.0,
        largest_overlap=OVERLAP,
        skin=case.skin,
    )
    # cells of about 2.3 diameters, such that an even number of them spans the nozzle
    across = case.nozzle / max(1, round(case.nozzle / (2.34 * case.d)))
    layers = max(1, round(case.depth / (3.0 * case.d)))
    count = (round(case.width / across), layers, int(np.ceil(height / across)))
    size = np.array([case.width / count[0], case.depth / layers, across])
    air = gas_mixture(AIR, 101325.0, "gri30.yaml")
    gas = Gas(
        Grid(np.zeros(3), size, count, (False, True)),
        air,
        drag_gidaspow,
        nusselt_gunn,
        T=T_BED,
    )
    bed = Bed(simulation, gas, T=T_BED, heat_capacity=840.0)
    middle = 0.5 * case.width
    slot = (middle - 0.5 * case.nozzle, middle + 0.5 * case.nozzle)
    return bed, lambda on: gas.inlet(
        case.velocity,
        T_BED,
        *((slot, FLUX / float(air.density(case.T)), case.T) if on else ()),
    )


def reference() -> dict[str, tuple[float, float]]:
    """Temperature of the hottest particles that the paper names [K], for injection
    over twice the time.
    """
    return {"T_particle_max [K]": (320.0, 370.0)}


def bubble(gas: Gas) -> tuple[float, float, float]:
    """Diameter of a cylinder as large as the bubble in the bed [m], its mean gas
    temperature [K], its centre [m].
    """
    eps, T = (field.reshape(gas.grid.count) for field in (gas.eps, gas.T))
    mean = eps.mean(axis=1)
    inside = largest_bubble(mean, OPEN)
    if inside is None:
        return 0.0, np.nan, np.nan
    weight = mean[inside]
    z = (np.nonzero(inside)[1] + 0.5) * gas.grid.size[2]
    diameter = equivalent_diameter(inside, gas.grid.size[0] * gas.grid.size[2])
    return (
        diameter,
        float((T.mean(axis=1)[inside] * weight).sum() / weight.sum()),
        float(z.mean()),
    )


def run(name: str) -> list[tuple[float, ...]]:
    """Bubble and hottest particle over time; particles and gas at some times are kept
    as raw fields.

    A run that was cut off goes on from its last sample, or from the settled bed.
    """
    case, folder = Case(name), raw(HERE.name) / name
    folder.mkdir(parents=True, exist_ok=True)
    start = gallery.user_time()
    kept = (
        checkpoint.load(folder)[0]
        if (folder / checkpoint.NAME).is_file()
        else {"rows": np.empty((0, 5))}
    )
    if "settled" not in kept:
        kept |= settled(case)
        checkpoint.save(folder, kept, {})
    packing = {key: kept[key] for key in ("settled", "height")}
    bed, inlet = coupled(case, packing)
    rows, shots = (
        kept["rows"].tolist(),
        {key: kept[key] for key in kept if key.startswith(("x_", "T_"))},
    )
    if rows:
        bed.restore(kept)

    for number in range(len(rows), round(END / EVERY)):
        inlet(number < round(DURATION / EVERY))
        bed.run((number + 1) * EVERY * case.scale - bed.time)
        rows.append((bed.time, *bubble(bed.gas), float(bed.T.max())))
        for t in SHOWN:
            if abs(bed.time - case.scale * t) < 0.25 * EVERY * case.scale:
                shots[f"x_{t}"] = bed.simulation.position[:, ::2].copy()
                shots[f"T_{t}"] = bed.gas.T.reshape(bed.gas.grid.count).mean(axis=1)
        checkpoint.save(
            folder, bed.state() | packing | shots | {"rows": np.array(rows)}, {}
        )
    balance = bed.balance()
    closed = balance["stored"] - balance["in"] + balance["out"] - balance["source"]
    print(
        f"{name}: {case.count} particles, {gallery.user_time() - start:.0f} s of CPU, "
        f"heat open by {closed:.1e} J"
    )
    if bed.above:
        print(
            f"{name}: {bed.above} times particles above the grid of the gas, where "
            "they feel none"
        )
    np.savez_compressed(folder.with_suffix(".npz"), size=bed.gas.grid.size, **shots)
    (folder / checkpoint.NAME).unlink()
    return rows


def compute(cases: Sequence[str] = CASES) -> Tables:
    """Bubble over time of each case; the committed rows of others are kept."""
    rows = [(name, *row) for name in cases for row in run(name)]
    table = Table({"case": "", **dict.fromkeys(COLUMNS, ".5g")}, rows)
    return {"bubble": Table.read(HERE / "bubble.csv").updated(table, ["case"])}


def plot(tables: Tables) -> dict[str, Any]:
    """Diameter and temperature of the bubble; the gas at some times where the fields
    are.
    """
    figure, axes = gallery.figure(1, 2, size=(11, 4.3))
    curves = []
    for name in tables["bubble"].values("case"):
        case, found = Case(name), tables["bubble"].where({"case": name})
        text = f"{1e3 * case.d:g} mm, {case.T:g} K" + (
            "" if case.scale == 1.0 else ", half bed"
        )
        how = {
            "ls": STYLES[round(1e3 * case.d)],
            "lw": 2.5 if case.scale == 1.0 else 1.3,
            "label": text,
        }
        colour = gallery.shades(1, "inferno", (case.T - 250.0) / 800.0)[0]
        curves.append(
            (*(found[column] for column in COLUMNS[:3]), {**how, "color": colour})
        )
    draw_bubbles(axes, curves)
    axes[0].legend()
    figures = {"bubble": figure}
    for name in PICTURED:
        if (path := raw(HERE.name) / f"{name}.npz").exists():
            figures["snapshots"] = plot_gas(Case(name), np.load(path))
    return figures


def plot_gas(case: Case, data: Any) -> Any:
    """Temperature of the gas and particles at some times."""
    times = [t for t in SHOWN if f"T_{t}" in data]
    figure, panels = gallery.figure(
        1, len(times), size=(2.6 * len(times), 7.0), sharey=True
    )
    for axes, t in zip(np.atleast_1d(panels), times, strict=True):
        field, x = data[f"T_{t}"], data[f"x_{t}"]
        extent = (
            0.0,
            1e2 * case.width,
            0.0,
            1e2 * field.shape[1] * float(data["size"][2]),
        )
        image = axes.imshow(
            field.T, origin="lower", extent=extent, cmap="inferno", vmin=T_BED
        )
        axes.plot(*(1e2 * x.T), ",", color="0.8", alpha=0.6)
        axes.set(title=f"{case.scale * t:g} s", xlabel="x [cm]")
        figure.colorbar(image, ax=axes, orientation="horizontal", label="gas [K]")
    return figure
