"""Checks of what changes in the course of a run: series, initial profiles, and other
checks at each of their times.
"""

from __future__ import annotations

import inspect
from functools import partial, wraps
from typing import Any

from contbed.course.schedule import boundaries_in_time
from contbed.errors import SceneError
from contbed.packed_bed import scene as s
from contbed.packed_bed.inlets import (
    bed_axis,
    enters,
    given_velocity,
    velocity_key,
    velocity_vector,
)
from contbed.packed_bed.schedule import PHASES, VELOCITY
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.mesh import Mesh, MeshFile
from contbed.scene.profile import outside_of_the_bed, short_of_an_end
from contbed.scene.series import ProfileFile, series_of
from contbed.scene.toml_lines import Origin, parse_key
from contbed.scene.values import with_value

Boundaries = dict[str, s.Boundary]

NAMES = {"fluid": "gas", "solid": "solid"}


def require_flow(scene: s.Scene) -> None:
    """Refuse a bed at rest without [heat].

    Raises
    ------
    SceneError : with file and line
    """
    plug = all(conditions.type != "no_slip" for conditions in scene.boundary.values())
    given = given_velocity(scene.boundary, "fluid")
    velocity = 0.0 if given is None else given[1]
    moves = any(velocity) if isinstance(velocity, tuple) else velocity
    if plug and scene.heat is None and not moves:
        text = "nothing to solve: the gas is at rest and there is no [heat] table"
        if scene.radiation is not None:
            text += (
                "; radiation alone has no [region]: for heat that is released give "
                "[heat], with closures.conductivity_gas and conductivity_solids = 0 "
                "where radiation alone carries it"
            )
        raise _about_flow(scene, text)


def require_plug_flow(scene: s.Scene) -> None:
    """Refuse velocities that change with time in a bed whose flow is computed.

    Raises
    ------
    SceneError : with file, line and remedy
    """
    if any(path[-1] == VELOCITY for path, _ in series_of(scene.boundary)):
        raise _about_flow(
            scene,
            "velocities that change with time are for plug flow; make walls with "
            'type = "no_slip" "slip", or run one scene for each velocity, each with '
            "the [initial] temperatures from the profiles.csv of the one before",
        )


def _about_flow(scene: s.Scene, text: str) -> SceneError:
    key = velocity_key(scene.boundary, "fluid")
    return SceneError(f"{scene.origin.at(parse_key(key))}: {key}: {text}")


def initial_profiles_fit_the_bed(
    initial: s.Initial, mesh: Mesh, boundary: Boundaries, see: See, origin: Origin
) -> Mistakes:
    """Check that the files of initial temperatures can be read and lie within the
    bed.
    """
    for phase in PHASES:
        given, key = initial.given(phase), initial.key(phase)
        if not isinstance(given, ProfileFile):
            continue
        try:
            given.samples(origin.base, f"T_{phase}")
        except SceneError as error:
            yield key, str(error)
            continue
        if not isinstance(mesh, MeshFile):
            extent = mesh.extents[bed_axis(mesh, boundary)]
            yield from outside_of_the_bed(key, given.rows(origin.base), extent, see)


def initial_profiles_reach_both_ends(
    initial: s.Initial, mesh: Mesh, boundary: Boundaries, see: See, origin: Origin
) -> Mistakes:
    """Look for files of initial temperatures that leave much of the bed at the value
    of their first or last row.
    """
    if isinstance(mesh, MeshFile):
        return
    for phase in PHASES:
        given = initial.given(phase)
        if not isinstance(given, ProfileFile):
            continue
        rows = given.rows(origin.base)
        extent = mesh.extents[bed_axis(mesh, boundary)]
        yield from short_of_an_end(initial.key(phase), rows, extent, "temperature", see)


def at_each_time(check: Check) -> Check:
    """Return a check of a scene whose series are replaced by the values of each of
    their times, one after another.
    """

    @wraps(check)
    def each(origin: Origin, boundary: Boundaries, **given: Any) -> Mistakes:
        entering = partial(_without_idle_inflow, mesh=given.get("mesh"))
        for now in boundaries_in_time(boundary, origin, entering):
            yield from check(boundary=now, **given)

    signature = inspect.signature(check)
    extra = inspect.Parameter(
        "origin", inspect.Parameter.KEYWORD_ONLY, annotation=Origin
    )
    parameters = [*signature.parameters.values(), extra]
    each.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return each


def _without_idle_inflow(boundary: Boundaries, mesh: Mesh | None) -> Boundaries:
    """Return the conditions without temperatures of streams that do not enter at the
    moment.
    """
    if mesh is None or isinstance(mesh, MeshFile):
        return boundary
    found = dict(boundary)
    for phase in PHASES:
        velocity = velocity_vector(mesh, boundary, phase)
        if len(velocity) != mesh.dimension:
            continue
        for name, table in boundary.items():
            condition = table.condition(phase)
            if (
                condition is not None
                and condition.temperature is not None
                and enters(mesh, velocity, name) != 1
            ):
                found[name] = with_value(
                    found[name], (*table.key(phase), "temperature"), None
                )
    return found
