"""Hot gas injected into a bed at incipient fluidization: Patil, Peters and Kuipers, Figs 2-6.

python studies/patil_hot_bubble/study.py run CASE FOLDER     # one case into FOLDER/CASE.npz, e.g. 3mm_700
python studies/patil_hot_bubble/study.py plot FOLDER         # bubble.csv and the pictures from the cases found there
"""

import csv
import sys
import time
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.ndimage import label

from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.closures import drag_gidaspow, nusselt_gunn
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, box
from contbed.materials import gas_mixture

HERE = Path(__file__).parent
WIDTH, NOZZLE, DURATION = 0.21, 0.014, 0.18  # of the paper
END = 0.45  # s
FLUX, T_BED = 17.55, 300.0  # kg/m2/s through the nozzle, K
BACKGROUND = {1: 0.65, 2: 1.1, 3: 1.45}  # m/s by diameter in mm
COUNT, DEPTH = 45000, 0.018  # of the paper's bed of 3 mm, which sets the height
GLASS = Material(density=2526.0, youngs_modulus=5e6, restitution=0.97, sliding_friction=0.1)
OPEN = 0.8  # porosity above which a cell belongs to a bubble
EVERY = 0.0125  # s
SHOWN = (0.1, 0.2, 0.3, 0.4)  # s
AIR = "N2:0.79, O2:0.21"


class Case:
    """`3mm_700`: width and nozzle of the paper; `half_1mm_900`: width, height, nozzle and times halved.

    All are four diameters deep with periodic sides; the paper's beds are 6 to 10 deep, between walls.
    """

    def __init__(self, name):
        self.name = name
        size, T = name.removeprefix("half_").split("mm_")
        self.d, self.T, self.scale = 1e-3 * int(size), float(T), 0.5 if name.startswith("half_") else 1.0
        self.width, self.nozzle, self.depth = self.scale * WIDTH, self.scale * NOZZLE, 4.0 * self.d
        self.velocity = BACKGROUND[int(size)]
        self.count = round(COUNT * (3e-3 / self.d) ** 3 * self.depth / DEPTH * self.scale**2)


def settled(case):
    """Bed of particles, with strong damping: what moves in it later is the gas's work."""
    damped = replace(GLASS, restitution=0.3)
    return pack(
        (case.width, case.depth),
        radius=case.d / 2,
        count=case.count,
        periodic=(False, True),
        material=damped,
        seed=1,
        at_rest=1e-3,
    )


def coupled(case, packing):
    height = 2.0 * packing.statistics["height"]
    domain = Domain((0, 0, 0), (case.width, case.depth, np.inf), (False, True, False))
    spheres = Particles(packing.position, packing.radius)
    simulation = Simulation(spheres, [GLASS], box(domain), domain, impact_speed=1.0, largest_overlap=0.1)
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
        case.velocity, T_BED, *((slot, FLUX / float(air.density(case.T)), case.T) if on else ())
    )


def bubble(gas):
    """Diameter of a cylinder as large as the bubble in the bed [m], its mean gas temperature [K], its centre [m].

    The bubble is the largest connected region of columns through the depth with a porosity above OPEN that does not
    belong to the freeboard.
    """
    eps, T = (field.reshape(gas.grid.count) for field in (gas.eps, gas.T))
    mean = eps.mean(axis=1)
    parts, number = label(mean > OPEN)
    free = set(np.unique(parts[:, -1])) - {0}
    sizes = [0 if k in free else int((parts == k).sum()) for k in range(1, number + 1)]
    if not sizes or max(sizes) == 0:
        return 0.0, np.nan, np.nan
    inside = parts == 1 + int(np.argmax(sizes))
    area = inside.sum() * gas.grid.size[0] * gas.grid.size[2]
    weight = mean[inside]
    z = (np.nonzero(inside)[1] + 0.5) * gas.grid.size[2]
    return np.sqrt(4.0 * area / np.pi), float((T.mean(axis=1)[inside] * weight).sum() / weight.sum()), float(z.mean())


def run(name, folder):
    case = Case(name)
    bed, inlet = coupled(case, settled(case))
    start, rows, shots = time.process_time(), [], {}

    def sample(now):
        rows.append((now.time, *bubble(now.gas), float(now.T.max())))
        for t in SHOWN:
            if abs(now.time - case.scale * t) < 0.25 * EVERY * case.scale:
                shots[f"x_{t}"], shots[f"particles_{t}"] = now.simulation.position[:, ::2].copy(), now.T.copy()
                shots[f"T_{t}"] = now.gas.T.reshape(now.gas.grid.count).mean(axis=1)
                shots[f"eps_{t}"] = now.gas.eps.reshape(now.gas.grid.count).mean(axis=1)

    for on, seconds in ((True, DURATION), (False, END - DURATION)):
        inlet(on)
        bed.run(case.scale * seconds, EVERY * case.scale * 0.8, sample)
    balance = bed.balance()
    closed = balance["stored"] - balance["in"] + balance["out"] - balance["source"]
    facts = {"particles": case.count, "cpu_s": time.process_time() - start}
    facts |= {"heat_in_J": balance["in"], "heat_open_J": closed, "above": bed.above, "dt": bed.simulation.time_step}
    print(name, {key: float(f"{value:.4g}") for key, value in facts.items()}, flush=True)
    Path(folder).mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        Path(folder) / f"{name}.npz", rows=rows, size=bed.gas.grid.size, facts=list(facts.values()), **shots
    )


def found(folder):
    """Cases that were run, in order of scale, diameter and temperature: name, (t, diameter, T, z, hottest particle)."""
    names = sorted((path.stem for path in Path(folder).glob("*mm_*.npz")), key=lambda name: (len(name), name))
    return {name: np.load(Path(folder) / f"{name}.npz") for name in names}


def curves(cases, path):
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.3), layout="constrained")
    styles = {1: ":", 2: "--", 3: "-"}
    for name, data in cases.items():
        case = Case(name)
        t, diameter, T, _, _ = data["rows"].T
        shown = diameter > 0.0
        how = {"ls": styles[round(1e3 * case.d)], "color": plt.get_cmap("inferno")((case.T - 250.0) / 800.0)}
        label = f"{1e3 * case.d:g} mm, {case.T:g} K" + ("" if case.scale == 1.0 else ", half bed")
        axes[0].plot(t[shown], 1e2 * diameter[shown], label=label, lw=2.5 if case.scale == 1.0 else 1.3, **how)
        axes[1].plot(t[shown], T[shown], lw=2.5 if case.scale == 1.0 else 1.3, **how)
    axes[0].set(xlabel="time, s", ylabel="diameter of the bubble, cm")
    axes[1].set(xlabel="time, s", ylabel="mean gas temperature in the bubble, K")
    axes[0].legend(fontsize=8)
    figure.savefig(path, dpi=120)


def snapshots(name, data, path):
    case = Case(name)
    times = [t for t in SHOWN if f"T_{t}" in data]
    figure, panels = plt.subplots(1, len(times), figsize=(2.6 * len(times), 7.0), layout="constrained", sharey=True)
    for axes, t in zip(np.atleast_1d(panels), times, strict=True):
        field, x = data[f"T_{t}"], data[f"x_{t}"]
        extent = (0.0, 1e2 * case.width, 0.0, 1e2 * field.shape[1] * float(data["size"][2]))
        image = axes.imshow(field.T, origin="lower", extent=extent, cmap="inferno", vmin=T_BED)
        axes.plot(*(1e2 * x.T), ",", color="0.8", alpha=0.6)
        axes.set(title=f"{case.scale * t:g} s", xlabel="cm")
        figure.colorbar(image, ax=axes, orientation="horizontal", label="gas, K")
    figure.savefig(path, dpi=110)


def plot(folder):
    cases = found(folder)
    curves(cases, HERE / "bubble.png")
    for name in ("half_3mm_900", "3mm_900"):
        if name in cases:
            snapshots(name, cases[name], HERE / "snapshots.png")
    with open(HERE / "bubble.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        names = ("diameter [m]", "T_bubble [K]", "z_bubble [m]", "T_particle_max [K]")
        writer.writerow(("case", "t [s]", *names))
        for name, data in cases.items():
            writer.writerows((name, *(f"{value:.5g}" for value in row)) for row in data["rows"])
    for name, data in cases.items():
        t, diameter, T, _, hottest = data["rows"].T
        scale = Case(name).scale
        stop, late = (np.argmin(np.abs(t - scale * moment)) for moment in (DURATION, 0.3))
        print(
            name,
            f"end of injection: {1e2 * diameter[stop]:.2f} cm, {T[stop]:.0f} K; at {scale * 0.3:g} s: "
            f"{1e2 * diameter[late]:.2f} cm, {T[late]:.0f} K; early {T[np.isfinite(T)][0]:.0f} K; particles up to "
            f"{hottest.max():.0f} K; largest {1e2 * np.nanmax(diameter):.2f} cm",
        )


if __name__ == "__main__":
    if sys.argv[1] == "run":
        run(*sys.argv[2:4])
    else:
        plot(sys.argv[2])
