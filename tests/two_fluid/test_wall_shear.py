"""The shear of the gas on walls: its error on the mesh, against the exact impulse of a
flow that starts and the exact shear of one through particles.
"""

import numpy as np
import pytest

from contbed.loading import loads
from contbed.two_fluid import run as runs
from contbed.two_fluid import wall_shear
from contbed.two_fluid.plan import plan

RHO, MU, END, HEIGHT = 1.2, 1.8e-5, 0.5, 0.02


def bed(cells, particles=0.0):
    """Gas of 1 m/s that starts along the left wall, through particles at rest."""
    text = f"""
    model = "two_fluid"
    mesh = {{ type = "rectangle", length = 0.2, height = {HEIGHT}, cells = [{cells}, 2] }}
    gas = {{ density = {RHO}, viscosity = {MU} }}
    solids.beads = {{ diameter = 1e-4, density = 2500.0 }}
    boundary.left.type = "wall"
    boundary.right = {{ type = "wall", gas.wall = "slip" }}
    boundary.bottom = {{ type = "periodic", partner = "top" }}
    initial = {{ gas.velocity = 1.0, solids.beads.volume_fraction = {particles} }}
    two_fluid.gravity = 0.0
    time = {{ end = {END}, longest = "5 ms" }}
    """
    return runs.Run(plan(loads("\n".join(map(str.strip, text.splitlines())))))


@pytest.mark.parametrize(("cells", "error"), [(20, 0.549), (80, 0.061)])
def test_impulse_of_a_flow_that_starts(cells, error):
    """Stokes' first problem: 2 mu u sqrt(t/(pi nu)) per area. The mesh misses `error`,
    which the estimate covers, and names cells that are fine enough.
    """
    run, impulse = bed(cells), []

    def add(simulation):
        impulse.append(simulation.state.dt * simulation.state.wall_force_gas)

    run.bed.advance(END, add)
    exact = -2.0 * MU * HEIGHT * np.sqrt(END * RHO / (np.pi * MU))
    assert sum(impulse) / exact == pytest.approx(1.0 - error, abs=0.01)
    ((name, shear),) = wall_shear.shears(run.bed)
    assert name == "left"
    assert error - 0.01 < shear.error < error + 0.06
    assert shear.cell_size == pytest.approx(0.00235, rel=1e-3)
    found = wall_shear.judge(run.scene, run.bed)
    assert len(found) == (shear.error > 0.1)
    assert all("boundary.left: the shear of the gas" in text for text in found)


def test_shear_through_particles_is_that_of_brinkman_on_a_mesh():
    """With mu u'' = beta (u - U) on equal cells of a width 2 d the shear of the discrete
    flow is mu U/sqrt(l^2 + d^2), l = sqrt(mu/beta), to rounding.
    """
    count, width, thickness = 200, 0.01, 0.013
    link = 1.0 / width
    matrix = np.diag(np.full(count, 2.0 * link + width / thickness**2))
    matrix -= np.diag(np.full(count - 1, link), 1) + np.diag(
        np.full(count - 1, link), -1
    )
    matrix[0, 0] += link
    matrix[-1, -1] -= link
    u = np.linalg.solve(matrix, np.full(count, width / thickness**2))
    d = 0.5 * width
    assert u[0] / d == pytest.approx(1.0 / np.hypot(thickness, d), rel=1e-12)


def test_small_shear_beside_the_weight_is_not_reported():
    """Dense particles screen the wall within micrometres, and carry all weight."""
    run = bed(20, 0.5)
    run.bed.advance(1e-4)
    ((_, shear),) = wall_shear.shears(run.bed)
    assert shear.error > 0.9
    weighed = run.scene.model_copy(
        update={"two_fluid": run.scene.two_fluid.model_copy(update={"gravity": 9.81})}
    )
    assert wall_shear.judge(run.scene, run.bed)
    assert not wall_shear.judge(weighed, run.bed)
