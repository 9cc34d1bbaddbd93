"""Meshes graded to the layers next to walls in which radiation varies."""

from __future__ import annotations

from contbed.arrays import Array
from contbed.closures import optics as closures
from contbed.mesh.grading import Layers, equidistributed, graded, scale_for, widened
from contbed.radiation.optics import optics
from contbed.radiation.scene import Radiating, RadiationScene
from contbed.scene.mesh import MeshFile, MeshLine

# share of the rate of the most oblique ordinate, 1/mu = (n + 1/2)^2/1.446, that a mesh
# resolves
OBLIQUE = 0.4


def nodes(scene: RadiationScene) -> list[Array] | None:
    """Return graded coordinates for each direction of a built-in mesh without
    prescribed cells.
    """
    mesh, k = scene.mesh, scene.radiation.conductivity or 0.0
    if isinstance(mesh, MeshFile) or (mesh.cells is not None and not mesh.graded):
        return None
    scale = scale_for(scene.solver.tolerance, scene.solver.degree)
    if isinstance(mesh, MeshLine):
        layers = radiation_layers(scene, k, 0, mesh.length)
        if mesh.cells is None:
            return [graded(mesh.length, layers, scale=scale, coarse=mesh.length / 40)]
        return [equidistributed(mesh.length, layers, mesh.cells, scene.solver.degree)]
    found = []
    for direction, extent in enumerate(mesh.extents):
        layers = widened(radiation_layers(scene, k, direction, extent), extent)
        if mesh.cells is not None:
            found.append(equidistributed(extent, layers, mesh.cells[direction]))
        else:
            fine = scale if mesh.dimension == 2 else 1.0
            along = direction == (1 if mesh.sides[0][0] == "axis" else 0)
            found.append(
                graded(
                    extent,
                    layers,
                    coarse=extent / (40 if along and mesh.dimension == 3 else 12),
                    scale=fine,
                )
            )
    return found


def radiation_layers(
    scene: Radiating, conductivity: float, direction: int, extent: float
) -> Layers:
    """Return positions and widths of the layers next to radiating boundaries in which
    radiation varies.

    The rate is sqrt(K_a/D (1 + k_R/k)); the radiative conductivity k_R = 16 sigma T^3 D
    competes with the `conductivity` k [W/m/K] of the solid. Intensities of the
    ordinates vary in layers of cosines times the mean free path, whatever the albedo.
    """
    if scene.radiation is None or scene.radiation.level == "rosseland":
        return []
    c, mesh = optics(scene), scene.mesh
    hot = [
        (
            table.radiation.temperature
            or ((table.radiation.radiosity or 0.0) / closures.SIGMA) ** 0.25
        )
        for table in scene.boundary.values()
        if table.radiation is not None
    ]
    radiative = closures.conductivity(max(hot, default=0.0), c.diffusion)
    rate = (
        c.absorption
        / c.diffusion
        * (1.0 + radiative / conductivity if conductivity else 1.0)
    ) ** 0.5
    if scene.radiation.level == "ordinates":
        rate = max(
            rate,
            OBLIQUE * (scene.radiation.directions + 0.5) ** 2 / 1.446 * c.extinction,
        )
    if rate == 0.0:
        return []
    layers = []
    for position, name in zip((0.0, extent), mesh.sides[direction], strict=True):
        table = scene.boundary.get(name)
        if table is not None and table.radiation is not None:
            layers.append((position, min(1.0 / rate, extent)))
    return layers
