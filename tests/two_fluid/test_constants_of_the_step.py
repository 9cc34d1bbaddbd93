"""Numerical constants of the two-fluid step: one small check of each, which fails
with another value.
"""

from dataclasses import replace

import numpy as np
import pytest
from core_closures import bed, closures, line
from numpy.testing import assert_allclose
from pytest import approx

from contbed.two_fluid import boundary
from contbed.two_fluid.cell_velocities import FaceVelocities, Gathered, gather_solid
from contbed.two_fluid.fv import limiter
from contbed.two_fluid.linear.cg import empty_system
from contbed.two_fluid.model import Options
from contbed.two_fluid.solids_pressure import (
    Solids,
    add_compaction_flux,
    add_compaction_velocity,
    assemble_compaction,
)
from contbed.two_fluid.stress import Motion, Viscosities, add_stress

SIDES = {"left": boundary.WallCondition(), "right": boundary.WallCondition()}


@pytest.mark.parametrize("stiffness", [0.0, -0.05])
def test_cold_particles_have_hardly_any_stiffness(stiffness):
    """Without granular temperature and friction the implicit solids pressure stays
    finite and moves nothing.

    As does one that falls with the solids fraction, such as that of clusters: it is not
    stiff.
    """
    g, count = line(1.0, 10).geometry, 10
    system, flux = empty_system(g, 1), np.zeros(11)
    solids = Solids(
        np.full(count, 0.3),
        np.zeros(count),
        np.full(count, stiffness),
        2500.0,
        np.zeros(2),
    )
    assemble_compaction(g, 0.1, solids, flux, np.zeros(count), system)  # dt/dx = 1 s/m
    assert np.isfinite(system.content).all()
    assert 0.0 < (system.coef[:9] / system.content[:9]).max() < 1e-11


def test_friction_pushes_particles_out_of_open_faces_only():
    """By a rise y of p_solid/rho_s the flux per area grows by dt y/distance where the
    boundary is open; nothing comes back where p_solid falls.
    """
    g, dt, rise = line(1.0, 10).geometry, 1e-3, 0.2
    system, flux, velocity = empty_system(g, 1), np.zeros(11), np.empty(11)
    solids = Solids(
        np.full(10, 0.6), np.zeros(10), np.ones(10), 2500.0, np.array([0.0, 1.0])
    )
    assemble_compaction(g, dt, solids, flux, np.zeros(10), system)
    add_compaction_flux(g, dt, system, np.full((10, 1), rise), flux, velocity)
    assert_allclose(flux[:10], 0.0, atol=1e-15)  # no rounding: jumps of y are zero
    assert_allclose(flux[10], dt * rise / 0.05, rtol=1e-12)  # rounding
    add_compaction_flux(g, dt, system, np.full((10, 1), -2 * rise), flux, velocity)
    assert flux[10] == 0.0


@pytest.mark.parametrize(
    ("eps_s", "kept"),
    [(0.0567, 1.0 - 0.15**4), (0.189, 1.0 - 0.5**4), (0.378, 0.0), (0.5, 0.0)],
)
def test_compaction_velocity_fades_towards_packing(eps_s, kept):
    """Particles get 1 - (eps_s/(0.6 eps_max))^4 of it, none from 0.6 eps_max on."""
    g = line(1.0, 2).geometry
    u = np.zeros((2, 1))
    add_compaction_velocity(g, np.array([1.0, 0.0, 0.0]), 0.63, np.full(2, eps_s), u)
    # one of the two faces of each cell moves, with 1/eps_s of the velocity of the
    # mixture
    assert_allclose(u * eps_s * g.normal[0, 0], 0.5 * kept, atol=1e-12)


def test_cell_without_particles_on_its_faces():
    """It gets no velocity from them, and other cells the velocity of their faces to
    eleven digits.
    """
    g = line(1.0, 3).geometry
    nf, s = len(g.left), np.array([0.3, 0.3, 0.3])
    speed = 2.0 * g.normal[:, 0]
    for fraction, expected in ((0.3, 2.0), (0.0, 0.0)):
        out = Gathered(*(np.full((3, 1), np.nan) for _ in range(4)))
        faces = FaceVelocities(speed, speed, speed, speed, np.full(nf, fraction))
        gather_solid(g, faces, s, np.zeros((3, 1, 1)), np.zeros((3, 1, 1)), False, out)
        assert_allclose(out.solid, expected, rtol=1e-11)
        assert_allclose(out.h_solid, expected, rtol=1e-11)


def limited(count, s, flux, dt=1.0, highest=0.6):
    """Rounds and solids fractions of the limiter on a line of `count` cells of 1 m;
    `flux` is changed in place.
    """
    grid = line(float(count), count)
    out, upwind_cells = np.empty(count), np.zeros(count, dtype=bool)
    _, rounds = limiter.limit(
        grid.geometry,
        dt,
        limiter.Bounds(s, np.zeros(count), highest),
        flux,
        out,
        upwind_cells,
    )
    assert out.min() >= 0.0 and out.max() <= highest
    return rounds, out


def test_limiter_empties_a_cell_in_one_round():
    """What leaves is cut to what the cell holds, to eleven digits, and rounding asks
    for no second cut.
    """
    for s in np.random.default_rng(1).uniform(1e-3, 0.6, 200):
        flux = np.array([3.0, 0.0, 0.0])
        rounds, out = limited(2, np.array([s, 0.0]), flux, highest=0.63)
        assert rounds == 1
        assert 0.0 < out[0] < 1e-11 * s
        # exactly what may leave is not cut
        again = flux.copy()
        assert limited(2, np.array([s, 0.0]), again, highest=0.63)[0] == 0
        assert again[0] == flux[0]


@pytest.mark.parametrize(("count", "converges"), [(45, True), (100, False)])
def test_limiter_fills_a_row_cell_by_cell(count, converges):
    """Each round fills one cell of a row before a wall: 45 cells fill up. With 100 the
    limiter ends after 50 rounds, with room left.
    """
    flux = np.zeros(count + 1)
    flux[: count - 1] = 0.5
    s = np.full(count, 0.599)
    s[0] = 0.6
    rounds, out = limited(count, s, flux)
    assert rounds <= 51
    assert np.allclose(out[1:], 0.6, rtol=1e-9) == converges
    assert (rounds < 50) == converges
    assert out.sum() == approx(s.sum(), rel=1e-13)


def test_few_particles_do_not_bind_the_step():
    """Cells with less than 1e-6 of particles do not count in the Courant number."""
    b = bed(
        line(1.0, 10),
        closures(),
        SIDES,
        gravity=(0.0,),
        options=Options(courant=0.5, dt_max=1.0, dt_first=1.0),
    )
    for eps_s, expected in ((0.9e-6, 1.0), (1.1e-6, 0.5 / 200.0)):
        b.start(eps_s=eps_s)
        fluxes = b.state.fluxes._replace(
            outflow_gas=np.zeros(10), outflow_solid=np.full(10, 200.0)
        )
        b.state = replace(b.state, fluxes=fluxes)
        assert b.next_step() == approx(expected)


def test_excess_of_viscosity_is_over_relaxed():
    """Beside a cell without viscosity the stress on the jump has the linear mean of
    mu; implicit it counts twice.
    """
    grid = line(2.0, 2)
    g = grid.geometry
    b = bed(grid, closures(), SIDES, gravity=(0.0,))
    system = empty_system(g, 1)
    system.rhs[:] = 0.0
    u = np.array([[0.0], [1.0]])
    motion = Motion(u, np.zeros((2, 1, 1)), np.zeros((2, 1)), np.ones(2))
    fluid = Viscosities(np.full(2, 0.3), np.array([4.0, 0.0]), np.zeros(2))
    add_stress(g, b.model.edge.solid, fluid, motion, system, np.zeros(2))
    # the wall of the cell at rest takes nothing from it: what is left is the explicit
    # force of the excess, 4/2
    assert system.rhs[0, 0] == approx(2.0)
    assert system.coef[0, 0] == approx(2.0 * 2.0)
