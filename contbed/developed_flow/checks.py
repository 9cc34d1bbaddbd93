"""Checks of a scene of fully developed flow: mistakes that remain although every single value is valid."""

from __future__ import annotations

from contbed.closures.binding import bind
from contbed.developed_flow import scene as d
from contbed.developed_flow.closures import GIVES, KINDS
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See
from contbed.scene.toml_lines import Origin
from contbed.two_fluid.scene import Gas

LAMINAR = 2300.0  # Reynolds number of the section's width up to which the flow of a gas alone is laminar
MIN_PARTICLES_PER_RADIUS = 5.0  # least number of particles between centre and wall


def closures_exist(fully_developed: d.FullyDeveloped, origin: Origin) -> Mistakes:
    """Check that the closures exist and that the flow has the arguments that they need."""
    for key, kind in KINDS.items():
        if getattr(fully_developed, key) is None:
            continue
        try:
            bind(getattr(fully_developed, key), kind, GIVES[kind], origin.base)
        except SceneError as error:
            yield ("fully_developed", key), str(error)


def particles_fit(fully_developed: d.FullyDeveloped, solid: d.Solid, see: See) -> Mistakes:
    """Check that the section is wide enough for the particles to be treated as a continuum."""
    if fully_developed.radius < MIN_PARTICLES_PER_RADIUS * solid.particle_diameter:
        known = see("solid.particle_diameter")
        room = f"only {fully_developed.radius / solid.particle_diameter:.3g} particles from centre to wall"
        yield (
            ("fully_developed", "radius"),
            f"{room}, at least {MIN_PARTICLES_PER_RADIUS:g} make a continuum; see {known}",
        )


def reynolds(fully_developed: d.FullyDeveloped, gas: Gas) -> float:
    """Return the Reynolds number of the gas alone on the width of the section."""
    return 2.0 * fully_developed.radius * fully_developed.velocity * gas.density / gas.viscosity


def turbulence_needs_turbulence(fully_developed: d.FullyDeveloped, gas: Gas) -> Mistakes:
    """Refuse a turbulence closure where the gas alone is laminar."""
    Re = reynolds(fully_developed, gas)
    if fully_developed.turbulence and Re <= LAMINAR:
        yield (
            ("fully_developed", "turbulence"),
            f"the gas alone is laminar, Re = {Re:.3g} up to {LAMINAR:g}: leave this key out",
        )


def gas_is_laminar(fully_developed: d.FullyDeveloped, gas: Gas) -> Mistakes:
    """Look for a gas that would be turbulent without a closure for it."""
    Re = reynolds(fully_developed, gas)
    if Re > LAMINAR and not fully_developed.turbulence:
        yield (
            ("fully_developed", "velocity"),
            f"the gas alone would be turbulent, Re = {Re:.3g} above {LAMINAR:g}, and no turbulence is named: "
            'profiles hold where particles carry the stress; fully_developed.turbulence = "eddy_viscosity_nikuradse" '
            "adds it",
        )


CHECKS = (closures_exist, particles_fit, turbulence_needs_turbulence)
WARNINGS = (gas_is_laminar,)
