"""Local heat transfer coefficient around a horizontal tube in a bubbling bed: Hou, Zhou and Yu 2010, Figs. 12, 13."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

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
from studies import _gallery as gallery
from studies._gallery import Table, Tables

D, WIDTH, DEPTH, COUNT = 1.5e-3, 45e-3, 6e-3, 4000
TUBE, HEIGHT = 7.7e-3, 22.5e-3  # radius of the tube, height of its axis [m]
GLASS = Material(density=2600.0, youngs_modulus=2e6, restitution=0.9, sliding_friction=0.3)
AIR = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
K_PARTICLE, E_REAL = 1.1, 5e10  # W/m/K, Pa
SECTORS = 12
START, END, EVERY = 0.1, 0.9, 2e-3  # s
EXCESS = ("0.1", "0.4", "0.8")  # velocity over minimum fluidization [m/s]
ANGLE = (np.arange(SECTORS) + 0.5) * 360.0 / SECTORS
MECHANISMS = ("h [W/m2/K]", "contact", "gas in gaps", "convection", "contacts", "porosity")


def minimum_velocity() -> float:
    """Superficial velocity at which Ergun's pressure drop carries the bed at a porosity of 0.42 [m/s]."""
    eps, mu, rho = 0.42, 1.8e-5, 1.2
    a, b = 1.75 * rho * (1 - eps) / (eps**3 * D), 150 * mu * (1 - eps) ** 2 / (eps**3 * D**2)
    return (-b + np.sqrt(b**2 + 4 * a * (1 - eps) * (GLASS.density - rho) * 9.81)) / (2 * a)


def bed(velocity: float) -> Bed:
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


def reference(speed: Any) -> Any:
    """The paper's coefficient of convection [W/m2/K], Nu = 0.023 Re^0.8 Pr^0.4 with the diameter of the tube."""
    rho, mu, c_p, k = 1.2, 1.8e-5, 1005, 0.026
    return 0.023 * (rho * speed * 2 * TUBE / mu) ** 0.8 * (mu * c_p / k) ** 0.4 * k / (2 * TUBE)


def around_tube(now: Bed) -> Any:
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
    close = np.abs((way[None] - ANGLE[:, None] + 180.0) % 360.0 - 180.0) < 30.0
    mean = (close * speed).sum(axis=1) / close.sum(axis=1)
    inside = (gap > -D / 2) & (gap < D / 2)
    solid = np.bincount(sector[inside], np.full(inside.sum(), np.pi * D**3 / 6), SECTORS)
    return np.array([*sums[:2], reference(mean), sums[2], solid])


def means(excess: str) -> Any:
    """Mean coefficients [W/m2/K] of contact, gas in gaps and convection, contacts, porosity: (5, SECTORS)."""
    now, samples = bed(minimum_velocity() + float(excess)), []
    now.run(START)
    now.run(END - START, EVERY, lambda each: samples.append(around_tube(each)))
    found = np.mean(samples, axis=0)
    area = 2.0 * np.pi * TUBE * DEPTH / SECTORS
    ring = np.pi * ((TUBE + D) ** 2 - TUBE**2) * DEPTH / SECTORS
    return np.array([found[0] / area, found[1] / area, found[2], found[3], 1.0 - found[4] / ring])


def compute(cases: Sequence[str] = EXCESS) -> Tables:
    """Means by sector and around the tube for each excess velocity."""
    sectors, overall = [], []
    for excess in cases:
        contact, fluid, convection, contacts, eps = means(excess)
        columns = contact + fluid + convection, contact, fluid, convection
        sectors += [(float(excess), *row) for row in zip(ANGLE, *columns, contacts, eps, strict=True)]
        overall.append((float(excess), *(values.mean() for values in columns), contacts.sum(), eps.mean()))
    head = ["excess velocity [m/s]"]
    return {
        "sectors": Table(dict.fromkeys([*head, "angle [deg]", *MECHANISMS], ".4g"), sectors),
        "overall": Table(dict.fromkeys([*head, *MECHANISMS], ".4g"), overall),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Local coefficient and porosity over the angle."""
    figure, (left, right) = gallery.figure(1, 2, size=(11, 4.3))
    for excess in tables["sectors"].values("excess velocity [m/s]"):
        found = tables["sectors"].where({"excess velocity [m/s]": excess})
        h, eps = found["h [W/m2/K]"], found["porosity"]
        left.plot(found["angle [deg]"], h, "o-", label=f"{excess} m/s: mean {h.mean():.0f}")
        right.plot(found["angle [deg]"], eps, "o-", label=f"{excess} m/s")
    left.set(ylabel="local coefficient [W/m2/K]", ylim=(0, None))
    right.set(ylabel="porosity within one diameter")
    for axes in (left, right):
        axes.set(xlabel="angle from the bottom of the tube [deg]", xticks=range(0, 361, 60))
        axes.legend(title="excess velocity")
    return {"tube": figure}
