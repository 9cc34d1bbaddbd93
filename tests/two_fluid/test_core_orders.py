"""Order of the two-fluid step for a manufactured solution with eps, both velocities,
p and theta all live (V10).
"""

import numpy as np
import pytest
from core_closures import bed, closures, rectangle
from gmsh_meshes import unstructured
from pytest import approx

from contbed.two_fluid.boundary import GivenFields
from contbed.two_fluid.fv.reconstruction import limited_increment
from contbed.two_fluid.model import Options

RHO_GAS, RHO_SOLID, MU_GAS, K = 1.0, 3.0, 0.02, 2.0
MU, BULK, CONDUCTIVITY, GAMMA = 0.05, 0.03, 0.04, 0.5
NAMES = ("eps_s", "u_gas", "u_solid", "theta", "p")


def eps_s(x):
    return 0.3 + 0.08 * np.sin(1.1 * x[:, 0] + 0.4) * np.cos(0.9 * x[:, 1] - 0.2)


def theta(x):
    return 1.0 + 0.3 * np.cos(1.2 * x[:, 0] - 0.3) * np.sin(0.8 * x[:, 1] + 0.5)


def p(x):
    return 2 * np.sin(x[:, 0] + 0.2) * np.cos(1.3 * x[:, 1] + 0.1)


def u_gas(x):
    return np.stack(
        (
            1.5 + 0.4 * np.sin(x[:, 0] + 1.2 * x[:, 1]),
            0.8 + 0.3 * np.cos(1.3 * x[:, 0] - 0.7 * x[:, 1]),
        ),
        axis=1,
    )


def u_solid(x):
    return np.stack(
        (
            1.0 + 0.3 * np.cos(0.8 * x[:, 0] + x[:, 1]),
            0.6 + 0.2 * np.sin(1.1 * x[:, 0] + 0.6 * x[:, 1]),
        ),
        axis=1,
    )


def grad(f, x, step=1e-3):
    """Derivatives of fourth order, exact to 1e-10 or so, along a new last axis."""
    out = []
    for k in range(2):
        d = step * np.eye(2)[k]
        out.append(
            (8 * (f(x + d) - f(x - d)) - (f(x + 2 * d) - f(x - 2 * d))) / (12 * step)
        )
    return np.stack(out, axis=-1)


def stress(mu, bulk, u):
    def tau(x):
        slope = grad(u, x)
        trace = slope[:, 0, 0] + slope[:, 1, 1]
        shear = mu(x)[:, None, None] * (slope + slope.transpose(0, 2, 1))
        return shear + ((bulk(x) - 2 / 3 * mu(x)) * trace)[:, None, None] * np.eye(2)

    return tau


def divergence(f, x):
    slope = grad(f, x)
    return slope[..., 0, 0] + slope[..., 1, 1]


def sources(x):
    """Accelerations of both phases and granular energy that the fields need."""
    s, ug, us = eps_s(x)[:, None], u_gas(x), u_solid(x)
    tau_g = stress(lambda x: MU_GAS + 0 * x[:, 0], lambda x: 0 * x[:, 0], u_gas)
    tau_s = stress(lambda x: MU * eps_s(x), lambda x: BULK * eps_s(x), u_solid)

    def p_solid(x):
        return RHO_SOLID * eps_s(x) * theta(x)

    def along(u, f):
        return np.einsum("n...j,nj->n...", grad(f, x), u)

    gas = (
        RHO_GAS * (1 - s) * along(ug, u_gas)
        + (1 - s) * grad(p, x)
        - divergence(tau_g, x)
        + K * s * (ug - us)
    )
    solid = (
        RHO_SOLID * s * along(us, u_solid)
        + s * grad(p, x)
        + grad(p_solid, x)
        - divergence(tau_s, x)
    )
    solid -= K * s * (ug - us)
    work = np.einsum("nij,nij->n", tau_s(x), grad(u_solid, x))
    conducted = divergence(
        lambda x: (CONDUCTIVITY * eps_s(x))[:, None] * grad(theta, x), x
    )
    energy = (
        1.5 * RHO_SOLID * s[:, 0] * along(us, theta)
        + p_solid(x) * divergence(u_solid, x)
        - work
        - conducted
    )
    energy += GAMMA * s[:, 0] ** 2 * theta(x) ** 1.5 + 3 * K * s[:, 0] * theta(x)
    return gas / (RHO_GAS * (1 - s)), solid / (RHO_SOLID * s), energy


def errors(cells, shape, limited):
    """L2 errors of all fields after 0.2 s from the exact fields, with dt as the
    square of the cell size.
    """
    if shape.endswith("s"):
        grid = unstructured(shape, 1.0, 1.0, 1.0 / cells)
    else:
        grid = rectangle(1.0, 1.0, (cells, cells), shape=shape)
    g, x, dt = grid.geometry, grid.centres, 0.2 / round(0.2 * cells**2)
    given = GivenFields(u_gas, u_solid, eps_s, theta)
    laws = closures(K, 1.0, MU, BULK, CONDUCTIVITY, GAMMA)
    materials = {"rho_gas": RHO_GAS, "mu_gas": MU_GAS, "rho_solid": RHO_SOLID}
    b = bed(
        grid,
        laws,
        dict.fromkeys(grid.boundaries, given),
        options=Options(limited=limited, dt=dt),
        **materials,
    )
    for source, flux in (
        (b.model.sources.solid, lambda x: eps_s(x)[:, None] * u_solid(x)),
        (b.model.sources.gas, lambda x: (1 - eps_s(x))[:, None] * u_gas(x)),
    ):
        through = (flux(grid.middles) * g.normal).sum(axis=1) * g.area
        np.add.at(source, g.left, through)
        np.subtract.at(source, g.right, through[: grid.interior])
        source /= g.volume
    (
        b.model.sources.force_gas[:],
        b.model.sources.force_solid[:],
        b.model.sources.theta[:],
    ) = sources(x)
    exact = {
        "eps_s": eps_s(x),
        "u_gas": u_gas(x),
        "u_solid": u_solid(x),
        "theta": theta(x),
        "p": p(x),
    }
    b.start(**exact)
    b.advance(0.2)
    found = b.state.fields()
    found["p"] = found["p"] + g.volume @ (exact["p"] - found["p"])
    difference = [(found[name] - exact[name]).reshape(len(x), -1) for name in NAMES]
    return np.array([np.sqrt(g.volume @ (d**2).sum(axis=1)) for d in difference])


def test_linear_profiles_are_reconstructed_exactly():
    """A slope of 1 per cell gives half of it at the face, limited or not; less the half
    step that goes the other way.

    The limiter gives nothing at an extremum, and at most twice the smaller difference
    (van Leer 1979).
    """
    for limited in (False, True):
        assert limited_increment(0.5, 1.0, 1.0, -0.1, limited) == approx(0.4)
        assert limited_increment(-0.5, -1.0, -1.0, 0.1, limited) == approx(-0.4)
    assert limited_increment(0.0, 0.0, 1.0, 0.0, True) == 0.0
    # differences of 0.2 before and 1.8 behind: the mean 1 is cut to 0.4
    assert limited_increment(0.5, 1.0, 0.2, 0.0, True) == approx(0.2)
    # 1.2 before and 0.8 behind: the mean stays, as twice the smaller one is larger
    assert limited_increment(0.5, 1.0, 1.2, 0.0, True) == approx(0.5)
    assert limited_increment(0.5, 1.0, 1.5, 0.0, True) == approx(0.5)


@pytest.mark.parametrize(("limited", "lowest"), [(False, 1.95), (True, 1.8)])
def test_order_on_quadrilaterals(limited, lowest):
    """Pressure is known to first order in V10; here it keeps 1.8."""
    coarse, fine = (errors(n, "quadrilateral", limited) for n in (20, 40))
    observed = dict(zip(NAMES, np.log2(coarse / fine), strict=True))
    assert min(observed[name] for name in NAMES[:4]) > lowest, observed
    assert observed["p"] > 1.8, observed


def test_order_on_triangles():
    """Halved rectangles, whose diagonals turn in the middle: an irregular line,
    where pressure is known less well.
    """
    coarse, fine = (errors(n, "triangle", False) for n in (10, 20))
    observed = dict(zip(NAMES, np.log2(coarse / fine), strict=True))
    assert min(observed.values()) > 1.8, observed


@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("shape", ["triangles", "quadrilaterals"])
def test_order_on_meshes_of_gmsh(shape, limited):
    """The gas remembers on faces what cells do not see, or p is noise over dt and
    velocities keep an order of 1.2. Errors of one mesh scatter by a third, hence a third
    of the size of cells.
    """
    coarse, fine = (errors(n, shape, limited) for n in (12, 36))
    observed = dict(zip(NAMES, np.log(coarse / fine) / np.log(3.0), strict=True))
    assert min(observed.values()) > 1.8, observed
