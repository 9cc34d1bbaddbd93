"""Heat transfer coefficients from packed to bubbling beds: Zhou, Yu, Zulli 2009,
Figs 3-7, and 2010, Fig. 10.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.heat_transfer import Average
from contbed.closures import drag_di_felice, drag_gidaspow, nusselt_power
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.statistics import surface
from contbed.materials.constant import ConstantFluid
from studies import _gallery as gallery
from studies._gallery import Table, Tables

D, WIDTH, COUNT = 2e-3, 26e-3, 2500
CELL = WIDTH / 4  # width of the cells of the gas [m]
GLASS = Material(
    density=2500.0,
    youngs_modulus=1e7,
    poisson_ratio=0.3,
    restitution=0.335,
    sliding_friction=0.3,
    rolling_friction=0.04,
)
AIR = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
NUSSELT = partial(nusselt_power, a=1.2, b=0.5)
VELOCITIES = (0.2, 0.42, 0.8, 1.0, 1.2, 1.3, 1.4, 1.6, 2.0, 2.4)
START, END, SAMPLE = 0.4, 0.8, 0.02  # s: averages from START on, every SAMPLE
# r_c times c = (E/E0)^(1/5) everywhere: an impact's heat then goes with c^2
PAPER = (1 / 5, 2 / 15)
CASES = {
    "0.08": Solid(0.08, 840.0, 5e10, PAPER),
    "0.84": Solid(0.84, 840.0, 5e10, PAPER),
    "30": Solid(30.0, 840.0, 5e10, PAPER),
    "0.84 at 10 MPa, no correction": Solid(0.84, 840.0),
    "0.84, exponents 1/3 and 1/5": Solid(0.84, 840.0, 5e10),
    "30 at 10 MPa, no correction": Solid(30.0, 840.0),
    "30, exponents 1/3 and 1/5": Solid(30.0, 840.0, 5e10),
}
HOT = 9
# of the distributions [W/m2/K]
BINS, SPANS = 60, {"convection": (60, 360), "conduction": (0, 180)}
CONDUCTION = ("fluid_touching", "fluid_apart", "contact", "impact")
COLOURS = {"0.08": gallery.BLUE, "0.84": gallery.GREEN, "30": gallery.VERMILION}
CORRECTIONS = {
    "0.84 at 10 MPa, no correction": ("s-", "10 MPa, $c$ = 1"),
    "0.84": ("o-", "10 MPa, $c$ = 0.182"),
    "0.84, exponents 1/3 and 1/5": ("^-", "10 MPa, powers 1/3 and 1/5"),
}
SHOWN = (0.42, 1.0, 1.4, 2.0)  # velocities of the distributions


def settled(count: int = COUNT, modulus: float = GLASS.youngs_modulus) -> Any:
    """Settle beads on a square floor that grows with their number, so that the bed
    keeps its height.
    """
    width, glass = (
        WIDTH * (count / COUNT) ** 0.5,
        replace(GLASS, youngs_modulus=modulus),
    )
    return pack((width, width), radius=D / 2, count=count, seed=1, material=glass)


def weight(packing: Any) -> float:
    """Weight of a bed over its area [Pa]."""
    width = packing.domain.upper[0]
    return len(packing) * np.pi / 6 * D**3 * GLASS.density * 9.81 / width**2


def bed(
    packing: Any,
    U: float,
    drag: Any = drag_di_felice,
    energy: bool = False,
    gas_step: float = 2e-4,
) -> Bed:
    simulation = Simulation(
        Particles(packing.position, packing.radius),
        [packing.material],
        packing.walls,
        packing.domain,
    )
    width = packing.domain.upper[0]
    across = round(width / CELL)
    size = np.array([width / across, width / across, 1.5 * D])
    gas = Gas(
        Grid(np.zeros(3), size, (across, across, 60)),
        AIR,
        drag,
        NUSSELT,
        T=300.0,
        isothermal=not energy,
    )
    gas.inlet(U, 300.0)
    T = None
    if energy:
        T = np.full(len(packing), 300.0)
        T[hot_ones(packing)] = 400.0
    return Bed(
        simulation,
        gas,
        gas_step,
        T,
        solid=CASES["0.84"] if energy else None,
        heat_interval=SAMPLE,
    )


def hot_ones(packing: Any) -> list[int]:
    """Nine spheres at three heights on three verticals."""
    top, width = packing.statistics["surface"], packing.domain.upper[0]
    spots = [
        (a * width, a * width, b * top)
        for a in (0.25, 0.5, 0.75)
        for b in (0.25, 0.5, 0.75)
    ]
    return [
        int(np.argmin(((packing.position - spot) ** 2).sum(axis=1))) for spot in spots
    ]


def one_velocity(packing: Any, U: float) -> dict[str, Any]:
    """Averages by mechanism for every case, coordination, hot spheres."""
    run = bed(packing, U, energy=True)
    averages = {name: Average(solid) for name, solid in CASES.items()}
    radiation = {
        T: Average(replace(CASES["0.84"], conductivity=0.0), 0.9, T)
        for T in (373.0, 1273.0)
    }
    drops, heights = [], []

    def sample(now):
        for average in (*averages.values(), *radiation.values()):
            average(now)
        drops.append(now.gas.pressure_drop)
        heights.append(float(np.percentile(now.simulation.position[:, 2], 99)))

    run.run(START)
    hot = hot_ones(packing)
    before = run.T[hot].copy()
    run.run(END - START, SAMPLE, sample)
    # cooling of the hot spheres in the time of the averages, as a thermocouple in them
    # would see it
    h_hot = (
        run.capacity[hot]
        / (np.pi * D**2)
        * np.log((before - 300.0) / (run.T[hot] - 300.0))
        / (END - START)
    )
    glass = averages["0.84"]
    conduction = glass.total - glass.mean["convection"]
    found = {
        "U": U,
        "coordination": glass.coordination,
        "porosity": float(glass.eps.mean()),
        "pressure_drop/weight": float(np.mean(drops)) / weight(packing),
        "height": float(np.mean(heights)),
        "cases": {name: average.bed_means() for name, average in averages.items()},
        "radiation": {
            f"{T:g}": average.bed_means()["radiation"]
            for T, average in radiation.items()
        },
        "hot_cooling": h_hot.tolist(),
        "hot_average": glass.total[hot].tolist(),
        "convection": np.percentile(glass.mean["convection"], [5, 50, 95]).tolist(),
        "conduction": np.percentile(conduction, [5, 50, 95]).tolist(),
        "above": run.above,
        "raised": run.gas.counts["raised"],
    }
    if U in SHOWN:
        found["distribution"] = {
            "convection": np.histogram(
                glass.mean["convection"], BINS, SPANS["convection"], density=True
            )[0].tolist(),
            "conduction": np.histogram(
                conduction, BINS, SPANS["conduction"], density=True
            )[0].tolist(),
        }
    print(
        f"{U:g} m/s: coordination {glass.coordination:.3f}, {run.above} above",
        flush=True,
    )
    return found


def minimum_fluidization(
    packing: Any, drag: Any
) -> tuple[list[Any], float, float, float]:
    """Pressure drop over weight while the velocity is lowered in steps; the crossing of
    its two branches [m/s].

    The velocity by Ergun [m/s] and the porosity of the bed that has come to rest
    follow.
    """
    run = bed(packing, 1.6, drag, gas_step=2e-4)
    run.run(0.3)
    rows = []
    for U in np.arange(1.5, 0.55, -0.1):
        run.gas.inlet(float(U), 300.0)
        run.run(0.06)
        drops = []
        run.run(
            0.06, 2e-3, lambda now, drops=drops: drops.append(now.gas.pressure_drop)
        )
        rows.append((float(U), float(np.mean(drops)) / weight(packing)))
    U, ratio = np.array(rows).T
    packed = ratio < 0.8
    power, level = np.polyfit(np.log(U[packed]), np.log(ratio[packed]), 1)
    # of the bed as it lies when it has come to rest again
    height = surface(run.simulation.position, run.simulation.radius)
    eps = 1 - weight(packing) / (GLASS.density * 9.81 * height)
    return rows, float(np.exp(-level / power)), reference(eps), eps


def reference(eps: float) -> float:
    """Velocity at which Ergun's pressure drop carries the bed [m/s]."""
    a, b = 1.75 / eps**3 * 1.2 / D, 150 * (1 - eps) / eps**3 * 1.8e-5 / D**2
    return float((-b + np.sqrt(b**2 + 4 * a * (2500.0 - 1.2) * 9.81)) / (2 * a))


def compute() -> Tables:
    """Minimum fluidization by two drags, and coefficients over the velocity."""
    packing = settled()
    fluidization = {
        drag.__name__: minimum_fluidization(packing, drag)
        for drag in (drag_gidaspow, drag_di_felice)
    }
    velocities = [one_velocity(packing, U) for U in VELOCITIES]
    curves = [(drag, *row) for drag, (rows, *_) in fluidization.items() for row in rows]
    return {
        "results": table(velocities),
        "mechanisms": mechanisms(velocities),
        "distributions": distributions(velocities),
        "fluidization": Table(
            {"drag": "", "U [m/s]": ".3g", "pressure drop/weight": ".4g"}, curves
        ),
        "U_mf": Table(
            {
                "drag": "",
                "U_mf [m/s]": ".5g",
                "by Ergun [m/s]": ".5g",
                "porosity": ".5g",
            },
            [(drag, *values) for drag, (_, *values) in fluidization.items()],
        ),
    }


def mechanisms(velocities: list[dict[str, Any]]) -> Table:
    """Coefficients by mechanism of every case and velocity."""
    names = ("convection", *CONDUCTION)
    rows = [
        (row["U"], case, *(parts[n] for n in names))
        for row in velocities
        for case, parts in row["cases"].items()
    ]
    return Table(
        {"U [m/s]": "g", "case": "", **{f"{name} [W/m2/K]": ".5g" for name in names}},
        rows,
    )


def distributions(velocities: list[dict[str, Any]]) -> Table:
    """Probability density of the coefficients of particles at some velocities."""
    rows = []
    for row in velocities:
        for name, values in row.get("distribution", {}).items():
            edges = np.linspace(*SPANS[name], BINS + 1)
            rows += [
                (row["U"], name, *pair)
                for pair in zip(0.5 * (edges[1:] + edges[:-1]), values, strict=True)
            ]
    return Table(
        {"U [m/s]": "g", "by": "", "h [W/m2/K]": "g", "density [m2K/W]": ".4g"}, rows
    )


def table(velocities: list[dict[str, Any]]) -> Table:
    """One row for each velocity, coefficients by mechanism for the three
    conductivities.
    """
    whole = {
        "total 0.84 E=10 MPa c=1": "0.84 at 10 MPa, no correction",
        "total 30 E=10 MPa c=1": "30 at 10 MPa, no correction",
        "total 30 exponents 1/3 1/5": "30, exponents 1/3 and 1/5",
    }
    out = []
    for row in velocities:
        cases = row["cases"]
        values = {
            "U [m/s]": f"{row['U']:g}",
            "porosity": row["porosity"],
            "coordination": row["coordination"],
        }
        values |= {
            "pressure drop/weight": row["pressure_drop/weight"],
            "h_convection": cases["0.84"]["convection"],
        }
        for k in COLOURS:
            parts = ("fluid_touching", "fluid_apart", "contact", "impact")
            values |= {f"{name} {k}": cases[k][name] for name in parts} | {
                f"total {k}": sum(cases[k].values())
            }
        values |= {name: sum(cases[case].values()) for name, case in whole.items()}
        values |= {f"radiation {T} K": row["radiation"][T] for T in ("373", "1273")}
        values |= {
            f"hot spheres by {how}": np.mean(row[f"hot_{how}"])
            for how in ("cooling", "average")
        }
        out.append(values)
    return Table.of(out, ".4g")


def plot(tables: Tables) -> dict[str, Any]:
    """Coefficients and shares over the velocity, and distributions."""
    return {
        "htc": plot_coefficients(tables),
        "distributions": plot_distributions(tables),
    }


def part(table: Table, case: str, *names: str) -> tuple[Any, Any]:
    """Velocities, and the sum of some mechanisms of a case."""
    found = table.where({"case": case})
    return found["U [m/s]"], sum(found[f"{name} [W/m2/K]"] for name in names)


def plot_coefficients(tables: Tables) -> Any:
    """Coefficients by conductivity, and what conducts."""
    found, U_mf = (
        tables["mechanisms"],
        tables["U_mf"].row("drag_di_felice")["U_mf [m/s]"],
    )
    figure, axes = gallery.figure(2, 2, size=(9.0, 6.6))
    for k, colour in COLOURS.items():
        whole = part(found, k, "convection", *CONDUCTION)
        axes[0, 0].plot(*whole, "o-", color=colour, label=f"$k_p$ = {k} W/m/K")
        axes[0, 1].plot(
            *part(found, k, *CONDUCTION),
            "s--",
            color=colour,
            label=f"conduction, {k} W/m/K",
        )
    axes[0, 1].plot(*part(found, "0.84", "convection"), "ko-", label="convection")
    axes[0, 0].set(ylabel="$h$ [W/m$^2$/K]", ylim=(0, None))
    groups = {
        "fluid, touching": ["fluid_touching"],
        "fluid, apart": ["fluid_apart"],
        "contact": ["contact", "impact"],
    }
    for panel, k in zip(axes[1], ("0.08", "30"), strict=True):
        U, whole = part(found, k, *CONDUCTION)
        for text, names in groups.items():
            panel.plot(U, 100 * part(found, k, *names)[1] / whole, "o-", label=text)
        panel.set_ylabel(f"share of conduction, $k_p$ = {k} [%]")
    for panel in axes.flat:
        panel.axvline(U_mf, color="0.6", linewidth=0.8)
        panel.set_xlabel("$U$ [m/s]")
        panel.legend()
    return figure


def plot_distributions(tables: Tables) -> Any:
    """Distributions over the particles, and what the correction of contacts changes."""
    figure, axes = gallery.figure(1, 3, size=(11.0, 3.4))
    found = tables["distributions"]
    for panel, name in zip(axes, SPANS, strict=False):
        for U in found.values("U [m/s]"):
            rows = found.where({"U [m/s]": U, "by": name})
            panel.plot(rows["h [W/m2/K]"], rows["density [m2K/W]"], label=f"{U} m/s")
        panel.set_xlabel(f"$h$ by {name} [W/m$^2$/K]")
    axes[0].set_ylabel("probability density [m$^2$K/W]")
    for case, (style, text) in CORRECTIONS.items():
        axes[2].plot(*part(tables["mechanisms"], case, *CONDUCTION), style, label=text)
    axes[2].set(
        xlabel="$U$ [m/s]",
        ylabel="conduction, $k_p$ = 0.84 [W/m$^2$/K]",
        ylim=(0, None),
    )
    for panel in axes:
        panel.legend()
    return figure
