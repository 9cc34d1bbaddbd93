"""Closures with few constants for tests of the two-fluid numerics, and beds made
with them.
"""

from dataclasses import replace

import numpy as np

from contbed.mesh import build as meshing
from contbed.scene.mesh import MeshLine, MeshRectangle
from contbed.two_fluid.fv import grid
from contbed.two_fluid.model import Materials, Options, build_model
from contbed.two_fluid.rheology import Closures, Rheology
from contbed.two_fluid.simulation import Simulation


def rectangle(length, height, cells, periodic=(), shape="quadrilateral", **mesh):
    """Grid of a rectangle of quadrilaterals, or of triangles."""
    chosen = MeshRectangle(
        type="rectangle", length=length, height=height, cells=cells, shape=shape, **mesh
    )
    return grid.build(meshing.build(chosen), periodic)


def line(length, cells, periodic=False):
    """Grid of a line along x, from left to right."""
    mesh = meshing.build(MeshLine(type="line", length=length, cells=cells))
    return grid.build(mesh, [("left", "right")] if periodic else [])


def closures(
    drag=0.0,
    pressure=0.0,
    viscosity=0.0,
    bulk=0.0,
    conductivity=0.0,
    dissipation=0.0,
    friction=0.0,
    eps_friction=0.5,
    rubbing=0.0,
):
    """K [kg/m3/s] is a number or a function of eps_s and slip, p_s = rho_s eps_s theta
    where `pressure` is 1.

    Viscosities and conductivity [Pa s] are times eps_s, gamma = dissipation eps_s^2
    theta^1.5. Above eps_friction, p_friction = rho_s `friction`
    (eps_s - eps_friction)^2, with the viscosity `rubbing` [Pa s].
    """

    def exchange(eps_s, slip):
        return drag(eps_s, slip) if callable(drag) else np.full(len(eps_s), float(drag))

    def granular(eps_s, theta, _):
        over = np.maximum(eps_s - eps_friction, 0.0)
        h = 2 * friction * (over - eps_friction * np.log1p(over / eps_friction))
        return Rheology(
            g0=np.ones_like(eps_s),
            pressure=pressure * eps_s,
            stiffness=pressure * theta + 2 * friction * over,
            mu=viscosity * eps_s,
            bulk=bulk * eps_s,
            p_friction=np.where(over > 0, 1.0, 0.0),
            potential=h,
            conductivity=conductivity * eps_s,
            dissipation=dissipation * eps_s**2,
        )

    return Closures(exchange, granular, lambda p, _: rubbing * p)


def bed(on, laws, boundaries, gravity=(0.0, 0.0), options=None, heat=None, **materials):
    """A bed with air and glass unless told otherwise."""
    values = {
        "rho_gas": 1.2,
        "mu_gas": 1.8e-5,
        "rho_solid": 2500.0,
        "d_p": 275e-6,
        "eps_max": 0.63,
    } | materials
    model = build_model(
        on,
        Materials(**values, gravity=gravity),
        laws,
        boundaries,
        options or Options(),
        heat,
    )
    return Simulation(model)


def solids(bed):
    """Volume of the solids [m3]."""
    return float(bed.state.eps_s @ bed.model.grid.geometry.volume)


def shaken(shape, cells, amount=0.15, seed=1):
    """Grid of a unit square whose inner nodes are moved at random by a share of the
    cell size.
    """
    return grid.build(shaken_mesh(shape, cells, amount, seed))


def shaken_mesh(shape, cells, amount=0.15, seed=1):
    """Mesh of a unit square whose inner nodes are moved at random by a share of the
    cell size.
    """
    mesh = meshing.build(
        MeshRectangle(
            type="rectangle", length=1.0, height=1.0, cells=cells, shape=shape
        )
    )
    p = mesh.skfem.p.copy()
    inner = ((p > 1e-9) & (p < 1 - 1e-9)).all(axis=0)
    p[:, inner] += (
        amount / cells[0] * np.random.default_rng(seed).uniform(-1, 1, (2, inner.sum()))
    )
    return replace(mesh, skfem=replace(mesh.skfem, doflocs=p))
