"""Whether a bed is thick enough for the Rosseland conductivity: its error between
walls, estimated.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.closures.optics import error_rosseland
from contbed.radiation.scene import Radiating, RadiatingSolid, Radiation
from contbed.scene.checking import Mistakes
from contbed.scene.mesh import Mesh, MeshAxisymmetric, MeshFile, MeshLine, MeshRectangle

TOLERANCE = 0.01  # estimated error from which a bed is too thin for Rosseland
HOPF = 1.4209  # twice the constant of Hopf: slips of temperature at black plates
THICK = 3.0  # optical depth from which the two-flux method is compared with exact heat
MOVES = (
    "is not estimated where the solids move: layers at walls may be thinner than "
    "the bed"
)


def estimate(scene: Radiating, mesh: Any) -> float:
    """Estimate the relative error of the Rosseland flux between the walls of a built-in
    bed, by `error_rosseland`.

    The direction with the largest error counts among those with a radiating wall, or
    the length of a bed without any. A side that does not radiate counts as black.
    """
    from contbed.radiation.optics import optics

    c = optics(scene)
    if isinstance(mesh, MeshLine):
        extents = [mesh.length]
    elif isinstance(mesh, MeshRectangle):
        extents = [mesh.length, mesh.height]
    elif isinstance(mesh, MeshAxisymmetric):
        extents = [2.0 * mesh.radius, mesh.length]
    else:
        extents = [mesh.length, mesh.width, mesh.height]
    errors = []
    for extent, names in zip(extents, mesh.sides, strict=True):
        walls = [
            scene.boundary[name].radiation for name in names if name in scene.boundary
        ]
        emissivities = [wall.emissivity for wall in walls if wall is not None]
        if emissivities:
            opposite = emissivities[0] if names[0] == "axis" else 1.0
            both = (*emissivities, opposite)[:2]
            errors.append(float(error_rosseland(extent / (3.0 * c.diffusion), *both)))
    return (
        max(errors)
        if errors
        else float(error_rosseland(mesh.length / (3.0 * c.diffusion)))
    )


def solids_move(boundary: Mapping[str, Any]) -> bool:
    """Return whether a boundary gives the solids a velocity."""
    conditions = [
        condition for table in boundary.values() for condition in table.solids.values()
    ]
    return any(
        condition.velocity is not None and np.any(condition.velocity)
        for condition in conditions
    )


def rosseland_is_thick(
    radiation: Radiation | None,
    solids: Mapping[str, RadiatingSolid],
    packed_bed: Any | None,
    boundary: Mapping[str, Any],
    mesh: Mesh,
) -> Mistakes:
    """Look for beds that are too thin for the Rosseland conductivity that the scene
    asks for.
    """
    if (
        radiation is None
        or radiation.level != "rosseland"
        or isinstance(mesh, MeshFile)
    ):
        return
    scene = SimpleNamespace(
        radiation=radiation, solids=solids, packed_bed=packed_bed, boundary=boundary
    )
    error = estimate(scene, mesh)
    if error > TOLERANCE:
        yield (
            ("radiation", "level"),
            f"heat between walls is too large by about {100.0 * error:.4g} %: the bed "
            "is too thin; use p1",
        )


def two_flux_is_low(
    radiation: Radiation | None,
    solids: Mapping[str, RadiatingSolid],
    packed_bed: Any | None,
    mesh: Mesh,
) -> Mistakes:
    """Look for beds in which the two-flux method carries too little heat from wall to
    wall; a medium of given temperatures emits on its own.
    """
    if radiation is None or radiation.level != "two_flux" or isinstance(mesh, MeshFile):
        return
    tables = (radiation, *solids.values())
    if any(getattr(table, "temperature", None) is not None for table in tables):
        return
    from contbed.radiation.optics import optics

    found = optics(
        SimpleNamespace(radiation=radiation, solids=solids, packed_bed=packed_bed)
    )
    extent = max(mesh.extents)
    of_transport = found.extinction - radiation.anisotropy * found.scattering
    yield from carries_less(
        found.extinction * extent, of_transport * extent, "p1 or rosseland"
    )


def carries_less(tau: float, of_transport: float, other: str) -> Mistakes:
    """Yield how much less heat the two-flux method carries than there is.

    Between black plates it has sigma (T_1^4 - T_2^4)/(1 + tau), exact is
    4/3/(tau (1 - omega g) + 1.4209), Heaslet and Warming 1965, Int. J. Heat Mass
    Transfer 8, 979-994, eq. 40, within 1 % from tau = 3 on.

    Parameters
    ----------
    tau, of_transport : optical depth, and that times 1 - omega g
    other : levels to use
    """
    low = 1.0 - 0.75 * (of_transport + HOPF) / (1.0 + tau)
    if tau >= THICK and low > 0.0:
        yield (
            ("radiation", "level"),
            f"the bed has an optical depth of {tau:.3g}, over which the two-flux "
            f"method carries {100.0 * low:.2g} % less heat than there is; use {other}",
        )


def rosseland_rests(
    radiation: Radiation | None, boundary: Mapping[str, Any]
) -> Mistakes:
    """Look for the Rosseland conductivity beside radiating walls along which solids
    move.
    """
    if radiation is None or radiation.level != "rosseland" or not solids_move(boundary):
        return
    if any(conditions.radiation is not None for conditions in boundary.values()):
        yield ("radiation", "level"), f"its error {MOVES}; compare with p1"
