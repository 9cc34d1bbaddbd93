"""Heat transfer coefficients from packed to bubbling beds: Zhou, Yu, Zulli 2009, Figs 3-7, and 2010, Fig. 10.

python studies/zhou_2009_htc/study.py            # everything, about 10 min on one core
python studies/zhou_2009_htc/study.py plot       # table and pictures from results.json
"""

import csv
import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

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

HERE = Path(__file__).parent
D, WIDTH, COUNT = 2e-3, 26e-3, 2500
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
PAPER = (1 / 5, 2 / 15)  # r_c times c = (E/E0)^(1/5) everywhere: an impact's heat then goes with c^2
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
SHOWN = (0.42, 1.0, 1.4, 2.0)  # velocities of the distributions


def settled():
    return pack((WIDTH, WIDTH), radius=D / 2, count=COUNT, seed=1, material=GLASS)


def bed(packing, U, drag=drag_di_felice, energy=False, gas_step=2e-4):
    simulation = Simulation(Particles(packing.position, packing.radius), [GLASS], packing.walls, packing.domain)
    size = np.array([WIDTH / 4, WIDTH / 4, 1.5 * D])
    gas = Gas(Grid(np.zeros(3), size, (4, 4, 60)), AIR, drag, NUSSELT, T=300.0, isothermal=not energy)
    gas.inlet(U, 300.0)
    T = None
    if energy:
        T = np.full(COUNT, 300.0)
        T[hot_ones(packing)] = 400.0
    return Bed(simulation, gas, gas_step, T, solid=CASES["0.84"] if energy else None, heat_interval=SAMPLE)


def hot_ones(packing):
    """Nine spheres at three heights on three verticals."""
    top = packing.statistics["surface"]
    spots = [(a * WIDTH, a * WIDTH, b * top) for a in (0.25, 0.5, 0.75) for b in (0.25, 0.5, 0.75)]
    return [int(np.argmin(((packing.position - spot) ** 2).sum(axis=1))) for spot in spots]


def one_velocity(packing, U):
    """Averages by mechanism for every case, coordination, hot spheres."""
    run = bed(packing, U, energy=True)
    averages = {name: Average(solid) for name, solid in CASES.items()}
    radiation = {T: Average(replace(CASES["0.84"], conductivity=0.0), 0.9, T) for T in (373.0, 1273.0)}
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
    # cooling of the hot spheres in the time of the averages, as a thermocouple in them would see it
    h_hot = run.capacity[hot] / (np.pi * D**2) * np.log((before - 300.0) / (run.T[hot] - 300.0)) / (END - START)
    glass = averages["0.84"]
    conduction = glass.total - glass.mean["convection"]
    found = {
        "U": U,
        "coordination": glass.coordination,
        "porosity": float(glass.eps.mean()),
        "pressure_drop": float(np.mean(drops)),
        "height": float(np.mean(heights)),
        "cases": {name: average.bed_means() for name, average in averages.items()},
        "radiation": {f"{T:g}": average.bed_means()["radiation"] for T, average in radiation.items()},
        "hot_cooling": h_hot.tolist(),
        "hot_average": glass.total[hot].tolist(),
        "convection": np.percentile(glass.mean["convection"], [5, 50, 95]).tolist(),
        "conduction": np.percentile(conduction, [5, 50, 95]).tolist(),
        "above": run.above,
        "raised": run.gas.counts["raised"],
    }
    if U in SHOWN:
        found["distribution"] = {
            "convection": np.histogram(glass.mean["convection"], 60, (60, 360), density=True)[0].tolist(),
            "conduction": np.histogram(conduction, 60, (0, 180), density=True)[0].tolist(),
        }
    print(json.dumps({key: value for key, value in found.items() if key != "distribution"}), flush=True)
    return found


def minimum_fluidization(packing, drag):
    """Pressure drop over weight while the velocity is lowered in steps; the crossing of its two branches."""
    run = bed(packing, 1.6, drag, gas_step=2e-4)
    weight = COUNT * np.pi / 6 * D**3 * 2500.0 * 9.81 / WIDTH**2
    run.run(0.3)
    rows = []
    for U in np.arange(1.5, 0.55, -0.1):
        run.gas.inlet(float(U), 300.0)
        run.run(0.06)
        drops = []
        run.run(0.06, 2e-3, lambda now, drops=drops: drops.append(now.gas.pressure_drop))
        rows.append((float(U), float(np.mean(drops)) / weight))
    U, ratio = np.array(rows).T
    packed = ratio < 0.8
    power, level = np.polyfit(np.log(U[packed]), np.log(ratio[packed]), 1)
    # of the bed as it lies when it has come to rest again
    eps = 1 - COUNT * np.pi / 6 * D**3 / (WIDTH**2 * surface(run.simulation.position, run.simulation.radius))
    print(drag.__name__, rows, flush=True)
    return {"curve": rows, "U_mf": float(np.exp(-level / power)), "ergun": ergun(eps), "porosity": eps}


def ergun(eps):
    """Velocity at which Ergun's pressure drop carries the bed [m/s]."""
    a, b = 1.75 / eps**3 * 1.2 / D, 150 * (1 - eps) / eps**3 * 1.8e-5 / D**2
    return float((-b + np.sqrt(b**2 + 4 * a * (2500.0 - 1.2) * 9.81)) / (2 * a))


def main():
    packing = settled()
    results = {
        "bed": packing.statistics,
        "U_mf": {drag.__name__: minimum_fluidization(packing, drag) for drag in (drag_gidaspow, drag_di_felice)},
        "velocities": [one_velocity(packing, U) for U in VELOCITIES],
    }
    (HERE / "results.json").write_text(json.dumps(results, indent=1) + "\n")


def table(results):
    """results.csv: one row for each velocity, coefficients by mechanism for the three conductivities."""
    head = ["U [m/s]", "porosity", "coordination", "pressure drop/weight", "h_convection"]
    parts = ("fluid_touching", "fluid_apart", "contact", "impact")
    for k in ("0.08", "0.84", "30"):
        head += [f"{name} {k}" for name in (*parts, "total")]
    head += [
        "total 0.84 E=10 MPa c=1",
        "total 30 E=10 MPa c=1",
        "total 30 exponents 1/3 1/5",
        "radiation 373 K",
        "radiation 1273 K",
        "hot spheres by cooling",
        "hot spheres by average",
    ]
    weight = COUNT * np.pi / 6 * D**3 * 2500.0 * 9.81 / WIDTH**2
    with open(HERE / "results.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        for row in results["velocities"]:
            cases = row["cases"]
            values = [row["porosity"], row["coordination"], row["pressure_drop"] / weight]
            values.append(cases["0.84"]["convection"])
            for k in ("0.08", "0.84", "30"):
                values += [*(cases[k][name] for name in parts), sum(cases[k].values())]
            values += [
                sum(cases[name].values())
                for name in (
                    "0.84 at 10 MPa, no correction",
                    "30 at 10 MPa, no correction",
                    "30, exponents 1/3 and 1/5",
                )
            ]
            values += [row["radiation"]["373"], row["radiation"]["1273"]]
            values += [np.mean(row["hot_cooling"]), np.mean(row["hot_average"])]
            writer.writerow([row["U"], *(f"{value:.4g}" for value in values)])


def plots(results):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    rows = results["velocities"]
    U = np.array([row["U"] for row in rows])
    U_mf = results["U_mf"]["drag_di_felice"]["U_mf"]
    colours = {"0.08": "#0072B2", "0.84": "#009E73", "30": "#D55E00"}

    def part(case, *names):
        return np.array([sum(row["cases"][case][name] for name in names) for row in rows])

    conduction = ("fluid_touching", "fluid_apart", "contact", "impact")
    figure, axes = plt.subplots(2, 2, figsize=(9.0, 6.6), layout="constrained")
    for k, colour in colours.items():
        axes[0, 0].plot(U, part(k, "convection", *conduction), "o-", color=colour, label=f"$k_p$ = {k} W/m/K")
        axes[0, 1].plot(U, part(k, *conduction), "s--", color=colour, label=f"conduction, {k} W/m/K")
    axes[0, 1].plot(U, part("0.84", "convection"), "ko-", label="convection")
    axes[0, 0].set_ylabel("$h$ [W/m$^2$/K]")
    axes[0, 0].set_ylim(0, None)
    for panel, k in zip(axes[1], ("0.08", "30"), strict=True):
        whole = part(k, *conduction)
        for name, label in (("fluid_touching", "fluid, touching"), ("fluid_apart", "fluid, apart")):
            panel.plot(U, 100 * part(k, name) / whole, "o-", label=label)
        panel.plot(U, 100 * part(k, "contact", "impact") / whole, "o-", label="contact")
        panel.set_ylabel(f"share of conduction, $k_p$ = {k} [%]")
    for panel in axes.flat:
        panel.axvline(U_mf, color="0.6", linewidth=0.8)
        panel.set_xlabel("$U$ [m/s]")
        panel.legend(frameon=False, fontsize=8)
    figure.savefig(HERE / "htc.png", dpi=150)
    figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.4), layout="constrained")
    for row in rows:
        if "distribution" in row:
            for panel, name, end in ((axes[0], "convection", (60, 360)), (axes[1], "conduction", (0, 180))):
                edges = np.linspace(*end, 61)
                panel.plot(0.5 * (edges[1:] + edges[:-1]), row["distribution"][name], label=f"{row['U']:g} m/s")
                panel.set_xlabel(f"$h$ by {name} [W/m$^2$/K]")
    axes[0].set_ylabel("probability density [m$^2$K/W]")
    axes[2].plot(U, part("0.84 at 10 MPa, no correction", *conduction), "s-", label="10 MPa, $c$ = 1")
    axes[2].plot(U, part("0.84", *conduction), "o-", label="10 MPa, $c$ = 0.182")
    axes[2].plot(U, part("0.84, exponents 1/3 and 1/5", *conduction), "^-", label="10 MPa, powers 1/3 and 1/5")
    axes[2].set(xlabel="$U$ [m/s]", ylabel="conduction, $k_p$ = 0.84 [W/m$^2$/K]", ylim=(0, None))
    for panel in axes:
        panel.legend(frameon=False, fontsize=8)
    figure.savefig(HERE / "distributions.png", dpi=150)


if __name__ == "__main__":
    if sys.argv[1:] != ["plot"]:
        main()
    found = json.loads((HERE / "results.json").read_text())
    table(found)
    plots(found)
