"""Local heat transfer coefficient around a horizontal tube in a bubbling bed: Hou, Zhou and Yu 2010, Figs. 12 and 13.

python studies/hou_2010_tube/study.py run EXCESS FOLDER    # one excess velocity [m/s] into FOLDER/EXCESS.npz
python studies/hou_2010_tube/study.py plot FOLDER          # sectors.csv, overall.csv and tube.png
"""

import csv
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.closures import drag_gidaspow
from contbed.dem import heat_pair
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, Tube, box
from contbed.materials.constant import ConstantFluid

HERE = Path(__file__).parent
D, WIDTH, DEPTH, COUNT = 1.5e-3, 45e-3, 6e-3, 4000
TUBE, HEIGHT = 7.7e-3, 22.5e-3  # radius of the tube, height of its axis [m]
GLASS = Material(density=2600.0, youngs_modulus=2e6, restitution=0.9, sliding_friction=0.3)
AIR = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
K_PARTICLE, E_REAL = 1.1, 5e10  # W/m/K, Pa
SECTORS = 12
START, END, EVERY = 0.1, 0.9, 2e-3  # s
EXCESS = (0.1, 0.4, 0.8)  # m/s


def minimum_velocity():
    """Superficial velocity at which Ergun's pressure drop carries the bed at a porosity of 0.42 [m/s]."""
    eps, mu, rho = 0.42, 1.8e-5, 1.2
    a, b = 1.75 * rho * (1 - eps) / (eps**3 * D), 150 * mu * (1 - eps) ** 2 / (eps**3 * D**2)
    return (-b + np.sqrt(b**2 + 4 * a * (1 - eps) * (GLASS.density - rho) * 9.81)) / (2 * a)


def bed(velocity):
    """Bed with the tube: spheres that overlap it are left out of a settled packing."""
    packing = pack((WIDTH, DEPTH), radius=D / 2, count=COUNT, periodic=(False, True), material=GLASS, at_rest=1e-3)
    x = packing.position
    x = x[np.hypot(x[:, 0] - WIDTH / 2, x[:, 2] - HEIGHT) > TUBE + D / 2]
    domain = Domain((0, 0, 0), (WIDTH, DEPTH, np.inf), (False, True, False))
    walls = [*box(domain), Tube((WIDTH / 2, 0, HEIGHT), (0, 1, 0), TUBE)]
    simulation = Simulation(Particles(x, D / 2), [GLASS], walls, domain, impact_speed=0.5, largest_overlap=0.1)
    count = (12, 2, 40)
    size = np.array([WIDTH / 12, DEPTH / 2, WIDTH / 12])
    # cells with all their corners so near to the axis that the centre of a sphere is never in them
    middle = np.array([WIDTH / 2, 0.0, HEIGHT])[:, None, None, None]
    at = np.abs((np.indices(count) + 0.5) * size[:, None, None, None] - middle)
    blocked = np.hypot(at[0] + 0.5 * size[0], at[2] + 0.5 * size[2]) < TUBE + 0.49 * D
    gas = Gas(Grid(np.zeros(3), size, count, (False, True), blocked), AIR, drag_gidaspow, tolerance=1e-6)
    gas.inlet(velocity, 300.0)
    return Bed(simulation, gas, gas_step=2e-4)


def around_tube(now):
    """By sector from below (0 deg) counterclockwise: conductances [W/K] by contact, through the gas and by convection,
    number of contacts, share of the ring of one diameter that is solid."""
    simulation, gas = now.simulation, now.gas
    dx, dz = simulation.position[:, 0] - WIDTH / 2, simulation.position[:, 2] - HEIGHT
    off = np.hypot(dx, dz)
    gap = off - TUBE - D / 2
    sector = (np.degrees(np.arctan2(dx, -dz)) % 360.0 / (360.0 / SECTORS)).astype(int) % SECTORS
    near = gap < 0.5 * D / 2  # as for two spheres, half of the gap between a sphere and its mirror image
    # an isothermal plane is the middle between a sphere and its mirror image: twice the conductance of that pair
    apart, R = D + 2.0 * gap[near], D / 2
    c = heat_pair.correction(GLASS.youngs_modulus, E_REAL, heat_pair.STATIC)
    r_c = heat_pair.contact_radius(R, R, apart, c)
    local = gas.around(now.motion)
    contact = 2.0 * heat_pair.contact_conductance(r_c, K_PARTICLE, K_PARTICLE)
    eps = np.clip(local.eps[near], 0.0, 0.9)
    fluid = 2.0 * heat_pair.gap_conductance(R, R, apart, K_PARTICLE, K_PARTICLE, 0.026, eps, r_c)
    sums = [np.bincount(sector[near], w, SECTORS) for w in (contact, fluid, 1.0 * (gap[near] < 0.0))]
    # the paper's Nu_D = 0.023 Re^0.8 Pr^0.4 with the diameter of the tube and the gas beside it
    grid = gas.grid
    centre = grid.centres
    ring = grid.open_cells & (np.hypot(centre[:, 0] - WIDTH / 2, centre[:, 2] - HEIGHT) < TUBE + 2.5 * D)
    faces = gas.q[grid.cell_face[ring]]
    speed = np.sqrt(((0.5 * (faces[:, ::2] + faces[:, 1::2])) ** 2).sum(axis=1))
    way = np.degrees(np.arctan2(centre[ring, 0] - WIDTH / 2, HEIGHT - centre[ring, 2])) % 360.0
    middles = (np.arange(SECTORS) + 0.5) * 360.0 / SECTORS
    close = np.abs((way[None] - middles[:, None] + 180.0) % 360.0 - 180.0) < 30.0
    mean = (close * speed).sum(axis=1) / close.sum(axis=1)
    h = 0.023 * (1.2 * mean * 2 * TUBE / 1.8e-5) ** 0.8 * (1.8e-5 * 1005 / 0.026) ** 0.4 * 0.026 / (2 * TUBE)
    inside = (gap > -D / 2) & (gap < D / 2)
    solid = np.bincount(sector[inside], np.full(inside.sum(), np.pi * D**3 / 6), SECTORS)
    return np.array([*sums[:2], h, sums[2], solid])


def run(excess, folder):
    start = time.process_time()
    now = bed(minimum_velocity() + float(excess))
    samples = []
    now.run(START)
    Path(folder).mkdir(parents=True, exist_ok=True)

    def sample(bed):
        samples.append(around_tube(bed))
        if len(samples) % 10 == 0:  # what there is can be plotted
            np.savez(Path(folder) / f"{excess}.npz", samples=samples)

    now.run(END - START, EVERY, sample)
    print(excess, f"{time.process_time() - start:.0f} CPU s, {len(now.simulation.position)} spheres", flush=True)


def means(folder, excess):
    """Mean coefficients [W/m2/K] of contact, gas in gaps and convection, contacts, porosity: (5, SECTORS)."""
    found = np.load(Path(folder) / f"{excess}.npz")["samples"].mean(axis=0)
    area = 2.0 * np.pi * TUBE * DEPTH / SECTORS
    ring = np.pi * ((TUBE + D) ** 2 - TUBE**2) * DEPTH / SECTORS
    return np.array([found[0] / area, found[1] / area, found[2], found[3], 1.0 - found[4] / ring])


def plot(folder):
    angle = (np.arange(SECTORS) + 0.5) * 360.0 / SECTORS
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.3), layout="constrained")
    sectors, overall = [], []
    for excess in EXCESS:
        contact, fluid, convection, contacts, eps = means(folder, excess)
        total = contact + fluid + convection
        left.plot(angle, total, "o-", ms=4, label=f"{excess:g} m/s: mean {total.mean():.0f}")
        right.plot(angle, eps, "o-", ms=4, label=f"{excess:g} m/s")
        sectors += [(excess, *row) for row in zip(angle, total, contact, fluid, convection, contacts, eps, strict=True)]
        overall.append((excess, *(v.mean() for v in (total, contact, fluid, convection)), contacts.sum(), eps.mean()))
    left.set(xlabel="angle from the bottom of the tube, deg", ylabel="local coefficient, W/m2/K", ylim=(0, None))
    right.set(xlabel="angle from the bottom of the tube, deg", ylabel="porosity within one diameter")
    for axes in (left, right):
        axes.set_xticks(range(0, 361, 60))
        axes.legend(title="excess velocity", fontsize=8)
    figure.savefig(HERE / "tube.png", dpi=120)
    names = ["h [W/m2/K]", "contact", "gas in gaps", "convection", "contacts", "porosity"]
    for name, head, rows in (("sectors", ["angle [deg]"], sectors), ("overall", [], overall)):
        with open(HERE / f"{name}.csv", "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["excess velocity [m/s]", *head, *names])
            writer.writerows([f"{value:.4g}" for value in row] for row in rows)
    for row in overall:
        print(*(f"{value:.4g}" for value in row))


if __name__ == "__main__":
    if sys.argv[1] == "run":
        run(*sys.argv[2:4])
    else:
        plot(sys.argv[2])
