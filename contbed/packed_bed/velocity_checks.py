"""Checks of the velocities at the boundaries of a packed bed."""

from __future__ import annotations

from contbed.packed_bed import scene as s
from contbed.packed_bed.inlets import enters, key_of, velocities_given
from contbed.packed_bed.schedule import PHASES
from contbed.packed_bed.schedule_checks import (
    NAMES,
    Boundaries,
    at_each_time,
)
from contbed.scene.checking import Mistakes, See
from contbed.scene.mesh import Mesh, MeshAxisymmetric
from contbed.scene.series import VelocitySeries
from contbed.scene.toml_lines import dotted


@at_each_time
def velocities_fit_the_mesh(mesh: Mesh, boundary: Boundaries, see: See) -> Mistakes:
    """Check that velocities have as many components as the mesh has dimensions, and
    enter where they are given.
    """
    for phase, name, value, key in velocities_given(boundary):
        vector = isinstance(value, tuple)
        if vector and len(value) != mesh.dimension:
            yield (
                key,
                f"has {len(value)} components, the mesh has {mesh.dimension} "
                f"dimensions; see {see('mesh.type')}",
            )
        elif isinstance(mesh, MeshAxisymmetric) and (
            value[0] if vector else value and name == "wall"
        ):
            yield (
                key,
                "the radial velocity is 0 in an axisymmetric bed; see "
                f"{see('mesh.type')}",
            )
        elif vector and any(value) and enters(mesh, value, name) == 0:
            yield (
                key,
                f"runs along '{name}'; give it at the boundary where the "
                f"{NAMES[phase]} enters",
            )


def velocities_are_given_once(boundary: Boundaries, see: See) -> Mistakes:
    """Check that one boundary gives the velocity of a phase."""
    for phase in PHASES:
        given = [
            key_of(boundary, name, phase, "velocity")
            for name, table in boundary.items()
            if (condition := table.condition(phase)) is not None
            and condition.velocity is not None
        ]
        for key in given[1:]:
            yield (
                key,
                f"one boundary gives the velocity of the {NAMES[phase]}; see "
                f"{see(dotted(given[0]))}",
            )


def velocities_are_meant_as_steps(
    boundary: Boundaries, time: s.Time | None
) -> Mistakes:
    """Look for velocities from a file, whose rows are seldom meant as steps, and for
    ramps, whose last value would never act.
    """
    for _, _, value, key in velocities_given(boundary):
        if not isinstance(value, VelocitySeries):
            continue
        if value.file is not None and "form" not in value.model_fields_set:
            yield (
                key,
                "holds from each row of the file to the next, while temperatures change "
                'linearly; write form = "step" if that is meant, or give closer rows',
            )
        elif value.times and time is not None and value.times[-1] >= time.end:
            yield (
                key,
                f"the velocity at {value.times[-1]:g} s never acts, as each holds until "
                "the next time and the run ends then: give a ramp as steps, at closer "
                "times",
            )
