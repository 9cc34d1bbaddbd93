"""Checks of a scene of developed flow: mistakes that remain although every single
value is valid.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from contbed.closures.binding import bind
from contbed.developed_flow import scene as d
from contbed.developed_flow.closures import GIVES, KINDS
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See
from contbed.scene.names import nearest
from contbed.scene.toml_lines import Origin

if TYPE_CHECKING:
    from contbed.materials.constants import Constants

# Reynolds number of the section's width up to which the flow of a gas alone is laminar
LAMINAR = 2300.0
MIN_PARTICLES_PER_RADIUS = 5.0  # least number of particles between centre and wall


def closures_exist(closures: d.Closures, origin: Origin) -> Mistakes:
    """Check that the closures exist and that the flow has the arguments that they
    need.
    """
    for key, kind in KINDS.items():
        if getattr(closures, key) is None:
            continue
        try:
            bind(getattr(closures, key), kind, GIVES[kind], origin.base)
        except SceneError as error:
            yield ("closures", key), str(error)


def solids_exist(solids: dict[str, d.Solid], boundary: d.Boundary) -> Mistakes:
    """Check that the wall names the solid of the scene."""
    for name in boundary.wall.solids:
        if name not in solids:
            yield (
                ("boundary", "wall", "solids", name),
                f"no such solid; {nearest(name, list(solids))}",
            )


def particles_fit(
    developed_flow: d.DevelopedFlow, solids: dict[str, d.Solid], see: See
) -> Mistakes:
    """Check that the section is wide enough for the particles to be treated as a
    continuum.
    """
    ((name, solid),) = solids.items()
    if developed_flow.radius < MIN_PARTICLES_PER_RADIUS * solid.diameter:
        known = see(f"solids.{name}.diameter")
        room = (
            f"only {developed_flow.radius / solid.diameter:.3g} particles from "
            "centre to wall"
        )
        text = (
            f"{room}, at least {MIN_PARTICLES_PER_RADIUS:g} make a continuum; see "
            f"{known}"
        )
        yield ("developed_flow", "radius"), text


def gas_has_properties(gas: d.Gas, origin: Origin) -> Mistakes:
    """Check that a gas whose properties vary has a temperature at which they are
    taken.
    """
    try:
        d.fluid_of(gas, origin.base)
    except SceneError as error:
        yield ("gas",), str(error)
    if gas.reference_temperature is not None and gas.model == "constant":
        yield (
            ("gas", "reference_temperature"),
            "has no use where the properties do not vary",
        )


def reynolds(developed_flow: d.DevelopedFlow, fluid: Constants) -> float:
    """Return the Reynolds number of the gas alone on the width of the section."""
    return (
        2.0
        * developed_flow.radius
        * developed_flow.gas_velocity
        * fluid.density
        / fluid.viscosity
    )


def turbulence_needs_turbulence(
    closures: d.Closures, developed_flow: d.DevelopedFlow, gas: d.Gas, origin: Origin
) -> Mistakes:
    """Refuse a turbulence closure where the gas alone is laminar."""
    try:
        Re = reynolds(developed_flow, d.fluid_of(gas, origin.base))
    except SceneError:
        return  # gas_has_properties reports it
    if closures.turbulence and Re <= LAMINAR:
        text = (
            f"the gas alone is laminar, Re = {Re:.3g} up to {LAMINAR:g}: leave this "
            "key out"
        )
        yield ("closures", "turbulence"), text


def gas_is_laminar(
    closures: d.Closures, developed_flow: d.DevelopedFlow, gas: d.Gas, origin: Origin
) -> Mistakes:
    """Look for a gas that would be turbulent without a closure for it."""
    Re = reynolds(developed_flow, d.fluid_of(gas, origin.base))
    if Re > LAMINAR and not closures.turbulence:
        yield (
            ("developed_flow", "gas_velocity"),
            f"the gas alone would be turbulent, Re = {Re:.3g} above {LAMINAR:g}, and "
            "no turbulence is named: "
            "profiles hold where particles carry the stress; closures.turbulence = "
            '"eddy_viscosity_nikuradse" '
            "adds it",
        )


def properties_are_known(gas: d.Gas, origin: Origin) -> Mistakes:
    """Look for properties at a temperature outside of their data."""
    if text := d.fluid_of(gas, origin.base).extrapolated:
        yield ("gas",), text


CHECKS = (
    closures_exist,
    solids_exist,
    gas_has_properties,
    particles_fit,
    turbulence_needs_turbulence,
)
WARNINGS = (gas_is_laminar, properties_are_known)
