"""Input of LAMMPS for spheres under the contact law of `contact`: a data file, commands
for contacts, walls, motion.

    ours                                          LAMMPS (package GRANULAR)
    4/3 E* a delta                                normal     hertz/material E e nu
    c_n sqrt(m* a) v_n, c_n = 2 sqrt(5/6) b ...   damping    coeff_restitution: sqrt(5) b sqrt(m* F_Hertz / delta)
    8 G* a xi, friction mu F_n                    tangential mindlin NULL x mu
    c_t = c_n sqrt(8 G*) / sqrt(2 E*)             x = 2 sqrt(G* / E*) = sqrt(2 (1 - nu) / (2 - nu))

Both are the same law as long as a contact sticks under load; b is that of
`particles.damping_ratio`. They differ

* in gross sliding with damping: LAMMPS compares spring and dashpot together with mu F_n
  and leaves in the spring what the dashpot is too much, here the spring alone is
  compared. That spring pushes the sphere on while the contact grows: the friction of
  one slide falls short of mu times the normal impulse, by 2 % at a restitution of 0.7,
  20 % at 0.3;
* where F_n pulls, in the last part of a damped impact: LAMMPS lets friction act up to
  mu |F_n|, here it is zero;
* in the arm of the spin: LAMMPS takes the radius for the velocity of the surface, at
  walls for the torque as well, here it is the distance to the contact, smaller by half
  an overlap, at walls by one;
* in the velocities of a step: LAMMPS takes those of its middle, here they are those of
  its end, both of first order.

Rolling friction is another law there (a spring with a slider), so that it is refused.

Source: LAMMPS manual, pair_style granular and fix wall/gran; fix nve/sphere and fix
    halt.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contbed.dem.particles import Material, Particles
from contbed.dem.settling import CHECK_EVERY, Stage
from contbed.dem.walls import Cylinder, Domain, Plane, Wall
from contbed.errors import SceneError

SKIN = 0.2  # of the smallest radius: room of the neighbour lists
# largest radii above the highest centre: no sphere that falls gets there
HEADROOM = 2.0
_AXES = {(1.0, 0.0, 0.0): "x", (0.0, 1.0, 0.0): "y", (0.0, 0.0, 1.0): "z"}


def data_text(particles: Particles, material: Material, domain: Domain) -> str:
    """Write the data file: box, diameters, density, centres, velocities and spins,
    all with 17 digits.
    """
    x, top = particles.position, HEADROOM * float(particles.radius.max())
    low = [
        low if np.isfinite(low) else float(x[:, k].min()) - top
        for k, low in enumerate(domain.lower)
    ]
    high = [
        high if np.isfinite(high) else float(x[:, k].max()) + top
        for k, high in enumerate(domain.upper)
    ]
    lines = ["spheres of contbed, SI", "", f"{len(x)} atoms", "1 atom types", ""]
    lines += [
        f"{low[k]!r} {high[k]!r} {name}lo {name}hi" for k, name in enumerate("xyz")
    ]
    lines += ["", "Atoms # sphere", ""]
    diameter = 2.0 * particles.radius
    lines += [
        f"{k + 1} 1 {d!r} {material.density!r} {a!r} {b!r} {c!r}"
        for k, (d, (a, b, c)) in enumerate(
            zip(diameter.tolist(), x.tolist(), strict=True)
        )
    ]
    motion = np.hstack((particles.velocity, particles.spin)).tolist()
    lines += ["", "Velocities", ""]
    lines += [
        f"{k + 1} " + " ".join(repr(value) for value in row)
        for k, row in enumerate(motion)
    ]
    return "\n".join(lines) + "\n"


def start_commands(domain: Domain, data: str, skin: float) -> list[str]:
    """Give the commands that read the data file; `skin` [m]."""
    sides = " ".join("p" if periodic else "f" for periodic in domain.periodic)
    return [
        "units si",
        "atom_style sphere",
        f"boundary {sides}",
        "newton off",
        "comm_modify vel yes",
        f"read_data {data}",
        f"neighbor {skin!r} bin",
        "neigh_modify delay 0 every 1 check yes",
    ]


def contact_commands(material: Material, walls: Sequence[Wall]) -> list[str]:
    """Give the commands for contacts of pairs and with walls, the fixes wall0, wall1,
    and so on.

    Raises
    ------
    SceneError : rolling friction; a wall that is neither an axis' plane nor a cylinder
        around the z axis
    """
    if material.rolling_friction > 0.0:
        raise SceneError(rolling_refused(material.rolling_friction))
    law = _law(material)
    lines = ["pair_style granular", f"pair_coeff * * {law}"]
    return lines + [
        f"fix wall{k} all wall/gran granular {law} {_place(wall)}"
        for k, wall in enumerate(walls)
    ]


def rolling_refused(friction: float) -> str:
    """Say that LAMMPS has another law of rolling."""
    return (
        f"rolling_friction = {friction:g}: LAMMPS has another law of rolling (a spring "
        "with a slider); "
        "set it to 0, or settle without --engine lammps"
    )


def settling_deck(
    domain: Domain,
    walls: Sequence[Wall],
    stages: Sequence[Stage],
    radius: float,
    gravity: float,
    scale: float,
) -> str:
    """Write the input file: all stages one after the other, then the centres as
    `settled.dump`.

    Parameters
    ----------
    domain, walls, stages : of the bed
    radius : the smallest one [m]
    gravity : [m/s2], downwards
    scale : N m g d of the bed [J], over which the kinetic energy is taken
    """
    lines = [
        "# spheres that settle under gravity, written by contbed: lmp -in packing.in",
        *start_commands(domain, "packing.data", SKIN * radius),
        "fix motion all nve/sphere",
        f"fix weight all gravity {gravity!r} vector 0 0 -1",
        "compute moving all ke",
        "compute turning all erotate/sphere",
        f"variable unrest equal (c_moving+c_turning)/{scale!r}",
        "thermo_style custom step v_unrest",
        "thermo_modify norm no flush yes format float %.8g",
        f"thermo {CHECK_EVERY}",
    ]
    for stage in stages:
        lines += [
            "",
            *contact_commands(stage.material, walls),
            "velocity all set 0 0 0",
            "set group all omega 0 0 0",
            f"timestep {stage.time_step!r}",
            "reset_timestep 0",
            f"fix rest all halt {CHECK_EVERY} v_unrest < {stage.at_rest!r} error "
            "continue message no",
            f"run {stage.steps}",
            "unfix rest",
            # springs start anew in the next part, as they do in our loop; the same pair
            # style would keep them
            "pair_style none",
            *(f"unfix wall{k}" for k in range(len(walls))),
        ]
    dump = (
        "write_dump all custom settled.dump id x y z radius modify sort id format "
        "float %.17g"
    )
    return "\n".join([*lines, "", dump]) + "\n"


def _law(material: Material) -> str:
    nu = material.poisson_ratio
    tangential = float(np.sqrt(2.0 * (1.0 - nu) / (2.0 - nu)))
    return (
        f"hertz/material {material.youngs_modulus!r} {material.restitution!r} {nu!r} "
        f"tangential mindlin NULL {tangential!r} {material.sliding_friction!r} damping "
        "coeff_restitution"
    )


def _place(wall: Wall) -> str:
    """Name a wall as fix wall/gran does."""
    if isinstance(wall, Plane):
        for normal, axis in _AXES.items():
            at = repr(float(wall.point["xyz".index(axis)]))
            if wall.normal == normal:
                return f"{axis}plane {at} NULL"
            if wall.normal == tuple(-n for n in normal):
                return f"{axis}plane NULL {at}"
    if (
        isinstance(wall, Cylinder)
        and wall.axis == (0.0, 0.0, 1.0)
        and wall.point[:2] == (0.0, 0.0)
    ):
        return f"zcylinder {float(wall.radius)!r}"
    raise SceneError(
        "packing: LAMMPS is given planes across x, y or z and a cylinder around the z "
        "axis; "
        f"settle without it for {type(wall).__name__.lower()} walls elsewhere"
    )
