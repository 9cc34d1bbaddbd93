"""Simulations that processors and GPUs compute alike."""

import numpy as np

from contbed.dem.contact_heat import ContactHeat
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, Tube, box

STEPS, HALF = 56, 24
STEEL = Material(2500.0, 1e6, 0.3, 0.8, 0.3, 0.05)
GLASS = Material(1500.0, 2e6, 0.3, 0.9, 0.5, 0.02)


def mixed(engine):
    """Two materials and sizes with rolling and temperatures, pushed, between walls,
    a tube and periodic sides.
    """
    rng, n = np.random.default_rng(1), 15
    domain = Domain((0.0, 0.0, 0.0), (6.75, 6.6, 8.0), (True, False, False))
    place = (
        np.array([(i, j, k) for k in range(3) for i in range(3) for j in range(3)])[:n]
        * [2.25, 2.1, 2.2]
        + 1.15
    )
    spheres = Particles(
        place + rng.uniform(-0.1, 0.1, (n, 3)),
        rng.choice([0.95, 1.05], n),
        rng.integers(0, 2, n),
        rng.normal(0.0, 1.5, (n, 3)),
        rng.normal(0.0, 1.0, (n, 3)),
    )
    walls = [
        *box(domain, 1, open_top=False),
        Tube((3.4, 3.0, 5.45), (0.0, 1.0, 0.0), 1.0),
    ]
    found = Simulation(
        spheres,
        [STEEL, GLASS],
        walls,
        domain,
        gravity=(0.2, 0.5, -2.0),
        impact_speed=1.0,
        largest_overlap=0.3,
        heat=ContactHeat([3e6, 5e5]),
        T=rng.uniform(300.0, 400.0, n),
        engine=engine,
    )
    found.force[:] = rng.normal(0.0, 3000.0, (n, 3))
    found.heat_source[:] = rng.normal(0.0, 1e6, n)
    return found


def pair(engine):
    """Two unlike spheres that meet off centre in free space, with spin and
    temperatures.
    """
    spheres = Particles(
        [[0.0, 0.0, 0.0], [1.1e-3, 1.0e-3, 0.4e-3]],
        [1e-3, 0.6e-3],
        [0, 1],
        [[0.3, 0.1, 0.0], [-0.2, 0.0, 0.1]],
        [[0.0, 30.0, 10.0], [20.0, 0.0, -40.0]],
    )
    heat = ContactHeat([400.0, 20.0], 500.0)
    return Simulation(
        spheres,
        [STEEL, GLASS],
        gravity=(0.0, 0.0, 0.0),
        impact_speed=0.5,
        largest_overlap=0.2,
        heat=heat,
        T=[400.0, 300.0],
        engine=engine,
    )


def stray(engine, halvings=0):
    """A sphere faster than the time step allows, and two that touch elsewhere."""
    radius, step = 1e-3, 2e-6
    x = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.50199, 0.0002, 0.0]]
    v = [[0.0, 0.0, 0.15 * radius / step], [0.3, 0.0, 0.0], [-0.3, 0.0, 0.0]]
    return Simulation(
        Particles(x, radius, velocity=v),
        [Material(youngs_modulus=1e7)],
        gravity=(0.0, 0.0, 0.0),
        time_step=step,
        impact_speed=1.0,
        most_halvings=halvings,
        engine=engine,
    )


def leaving(engine):
    """A sphere that leaves a domain without walls."""
    domain = Domain((0.0, 0.0, 0.0), (0.01, 0.01, 0.01))
    spheres = Particles([[0.0098, 0.005, 0.005]], 1e-3, velocity=[[1.0, 0.0, 0.0]])
    return Simulation(
        spheres, [Material()], (), domain, impact_speed=1.0, engine=engine
    )


def pushed(engine):
    """A sphere that a force pushes through a wall."""
    domain = Domain((-0.01, -0.01, 0.0), (0.01, 0.01, 0.01))
    spheres = Particles([[0.0, 0.0, 1e-3]], 1e-3)
    wide = Domain((-0.01, -0.01, -0.01), (0.01, 0.01, 0.01))
    found = Simulation(
        spheres, [Material(youngs_modulus=1e5)], box(domain)[4:5], wide, engine=engine
    )
    found.force[0, 2] = -1.0
    return found
