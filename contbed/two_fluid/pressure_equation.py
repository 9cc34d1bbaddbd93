"""Kernels of the pressure equation: what both fluxes are before it, and with the
pressure that it gives.
"""

from __future__ import annotations

from contbed.two_fluid.boundary import OUTLET, Edge
from contbed.two_fluid.cell_velocities import FaceVelocities
from contbed.two_fluid.compiled import Array, inner, kernel
from contbed.two_fluid.face_velocities import FaceFractions, FacePredictor, of_both
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.state import Fluxes


@inner
def flux_and_link(
    g: Geometry, f: int, fractions: FaceFractions, predictor: FacePredictor
) -> tuple[float, float]:
    """Flux of both phases through a face without the pressure [m3/s], and by how much
    it falls with the difference of the pressures.
    """
    star = of_both(fractions, f, predictor.star_gas[f], predictor.star_solid[f])
    mobility = of_both(
        fractions, f, predictor.mobility_gas[f], predictor.mobility_solid[f]
    )
    return g.area[f] * star, g.area[f] * mobility / g.distance[f]


@kernel
def assemble_pressure(
    g: Geometry,
    edge: Edge,
    fractions: FaceFractions,
    predictor: FacePredictor,
    coef: Array,
    rhs: Array,
) -> None:
    """Assemble sum of coef (nf,) (p - p_neighbour) = rhs (nc,) from the sum of both
    fluxes; `rhs` holds the sources.
    """
    for f in range(len(g.right)):
        flux, coef[f] = flux_and_link(g, f, fractions, predictor)
        rhs[g.left[f]] -= flux
        rhs[g.right[f]] += flux
    assemble_boundary_pressure(g, edge, fractions, predictor, coef, rhs)


@inner
def assemble_boundary_pressure(
    g: Geometry,
    edge: Edge,
    fractions: FaceFractions,
    predictor: FacePredictor,
    coef: Array,
    rhs: Array,
) -> None:
    """Add given fluxes and pressures of the boundary, see `assemble_pressure`."""
    ni, gas, solid = len(g.right), edge.gas, edge.solid
    for f in range(g.edge_from, g.edge_to):
        b, c = f - ni, g.left[f]
        if gas.kind[b] != OUTLET:
            coef[f] = 0.0
            rhs[c] -= g.area[f] * (gas.flux[b] + solid.flux[b])
            continue
        flux, coef[f] = flux_and_link(g, f, fractions, predictor)
        rhs[c] += coef[f] * edge.p[b] - flux


@kernel
def correct_fluxes(
    g: Geometry,
    edge: Edge,
    p: Array,
    fractions: FaceFractions,
    predictor: FacePredictor,
    faces: FaceVelocities,
    fluxes: Fluxes,
) -> None:
    """Set the velocities of `faces` with the pressure p (nc,), and the `fluxes` but
    for `moved`.
    """
    outflow_gas, outflow_solid = fluxes.outflow_gas, fluxes.outflow_solid
    outflow_gas[:] = 0.0
    outflow_solid[:] = 0.0
    for f in range(len(g.right)):
        left, right, area = g.left[f], g.right[f], g.area[f]
        drop = (p[right] - p[left]) / g.distance[f]
        u_g = predictor.star_gas[f] - predictor.mobility_gas[f] * drop
        u_s = predictor.star_solid[f] - predictor.mobility_solid[f] * drop
        faces.gas[f], faces.solid[f] = u_g, u_s
        fluxes.solid[f] = area * (fractions.solid[f] * u_s)
        fluxes.total[f] = area * of_both(fractions, f, u_g, u_s)
        outflow_gas[left] += max(0.0, area * u_g)
        outflow_solid[left] += max(0.0, area * u_s)
        outflow_gas[right] -= min(0.0, area * u_g)
        outflow_solid[right] -= min(0.0, area * u_s)
    correct_boundary_fluxes(g, edge, p, fractions, predictor, faces, fluxes)
    for c in range(len(g.volume)):
        outflow_gas[c] /= g.volume[c]
        outflow_solid[c] /= g.volume[c]


@inner
def correct_boundary_fluxes(
    g: Geometry,
    edge: Edge,
    p: Array,
    fractions: FaceFractions,
    predictor: FacePredictor,
    faces: FaceVelocities,
    fluxes: Fluxes,
) -> None:
    """Set velocities and fluxes of boundary faces, see `correct_fluxes`."""
    ni = len(g.right)
    for f in range(g.edge_from, g.edge_to):
        b, c, area = f - ni, g.left[f], g.area[f]
        drop = (edge.p[b] - p[c]) / g.distance[f]
        u_g = predictor.star_gas[f] - predictor.mobility_gas[f] * drop
        u_s = predictor.star_solid[f] - predictor.mobility_solid[f] * drop
        fluxes.solid[f] = area * (fractions.solid[f] * u_s)
        if edge.gas.kind[b] == OUTLET:
            fluxes.total[f] = area * of_both(fractions, f, u_g, u_s)
            if u_s < 0.0:
                # no particles come back: as at a wall
                fluxes.solid[f] = u_s = faces.h_solid[f] = 0.0
        else:
            fluxes.total[f] = area * (edge.gas.flux[b] + edge.solid.flux[b])
        faces.gas[f], faces.solid[f] = u_g, u_s
        fluxes.outflow_gas[c] += max(0.0, area * u_g)
        fluxes.outflow_solid[c] += max(0.0, area * u_s)
