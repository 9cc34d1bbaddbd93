"""What carries a bed, at rest and moving: pressures on the floor and walls, against
its weight.
"""

from dataclasses import replace

import numpy as np
import pytest
from core_closures import bed, closures, line, rectangle
from gmsh_meshes import KINDS, sides, unstructured
from pytest import approx

from contbed.two_fluid import momentum_budget, results
from contbed.two_fluid.boundary import (
    InletCondition,
    OutletCondition,
    WallCondition,
    symmetry,
)
from contbed.two_fluid.model import Options

SLIP = symmetry()
# fraction above which particles rub, p = rho_s STRENGTH (eps_s - LOOSE)^2
LOOSE, STRENGTH = 0.5, 200.0


def carried(cells, velocity):
    """What carries the bed between its lowest and highest cell with friction, over its
    weight; with the friction of the faces, and with that of the two cells.
    """
    sides = {
        "left": InletCondition(velocity) if velocity else symmetry(),
        "right": OutletCondition(),
    }
    laws = closures(
        1e4,
        pressure=1.0,
        viscosity=1.0,
        dissipation=1e5,
        friction=STRENGTH,
        eps_friction=LOOSE,
    )
    b = bed(line(0.2, cells), laws, sides, (-9.81,), Options(dt_max=4e-3))
    x = b.model.grid.centres[:, 0]
    b.start(eps_s=np.where(x < 0.1, 0.52, 0.0), theta=1e-6)
    b.advance(5.0)
    order = np.argsort(x)
    s = b.state.eps_s[order]
    rubbing = int((s > LOOSE).sum())
    s, p, h = (
        s[:rubbing],
        b.state.p[order][:rubbing],
        b.state.properties.rheology.potential[order][:rubbing],
    )
    mean = 0.5 * (s[1:] + s[:-1])
    weight = 9.81 * 0.2 / cells * (2500 * mean + 1.2 * (1 - mean)).sum()
    drop = p[0] - p[-1]
    friction = 2500 * STRENGTH * ((s[0] - LOOSE) ** 2 - (s[-1] - LOOSE) ** 2)
    return (drop - 2500 * (mean * np.diff(h)).sum()) / weight, (
        drop + friction
    ) / weight


def test_floor_carries_the_weight_of_a_bed_at_rest():
    # face by face to rounding; the friction of two cells is its integral between them
    # to second order
    (fine, fine_ends), (coarse, coarse_ends) = carried(40, 0.0), carried(20, 0.0)
    assert [fine, coarse] == approx([1.0, 1.0], abs=1e-10)
    assert abs(fine_ends - 1) < 5e-5
    assert abs(coarse_ends - 1) > 2 * abs(fine_ends - 1)


def test_gas_carries_its_part():
    # gas that speeds up through denser particles takes rho u^2 of it, 1e-5 of the
    # weight
    assert carried(20, 0.3)[0] == approx(1.0, abs=2e-5)


def measured(b):
    """Shares of the weight in one more step."""
    before = momentum_budget.momentum(b)
    b.step(b.next_step())
    return momentum_budget.shares(momentum_budget.forces(b, before))


def test_pressure_carries_a_uniform_suspension():
    s, u = 0.4, 0.5
    # K u = (1 - s) (rho_s - rho_g) g
    drag = (s * 2500 + (1 - s) * 1.2 - 1.2) * 9.81 * (1 - s) / s / u
    sides = {
        "left": SLIP,
        "right": SLIP,
        "bottom": InletCondition((1 - s) * u),
        "top": OutletCondition(),
    }
    b = bed(
        rectangle(0.1, 0.2, (5, 10)), closures(drag), sides, (0.0, -9.81), rho_gas=1.2
    )
    z, density = b.model.grid.centres[:, 1], s * 2500 + (1 - s) * 1.2
    b.start(
        eps_s=s,
        u_gas=np.stack((0 * z, 0 * z + u), axis=1),
        p=(0.2 - z) * density * 9.81,
    )
    found = measured(b)
    assert found["weight_pressure"] == approx(1.0, abs=1e-9)
    assert abs(found["weight_missing"]) < 1e-9


def test_walls_carry_what_falls_steadily():
    # nothing below or above: the shear of both phases on the walls is the weight,
    # whatever the momentum was before
    wall = WallCondition(gas="no_slip", solid="no_slip")
    grid = rectangle(0.1, 0.05, (8, 4), [("bottom", "top")])
    b = bed(
        grid,
        closures(50.0, viscosity=100.0),
        {"left": wall, "right": wall},
        (0.0, -9.81),
        mu_gas=1.0,
    )
    b.start(eps_s=0.3)
    b.step(1e-3)
    assert abs(measured(b)["weight_missing"]) < 1e-6  # of the solution of the system
    b.advance(2.0)
    found = measured(b)
    assert found["weight_walls"] == approx(1.0, abs=1e-6)
    assert abs(found["weight_missing"]) < 1e-6


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("roof", [WallCondition(), OutletCondition()])
def test_pressure_drop_reaches_from_floor_to_roof(kind, roof):
    """Exact where the pressure is linear, along the walls as well; an outlet has the
    pressure outside.
    """
    height, across, along = 0.12, 700.0, -1e4  # m; Pa/m
    on = unstructured(kind, 0.06, height, 0.03)
    b = bed(
        on,
        closures(),
        sides(on, WallCondition(), top=roof),
        (*(0.0,) * (on.dimension - 1), -9.81),
    )
    p = 500.0 + on.centres[:, -1] * along
    floor, outside = 500.0, 0.0
    if not on.axisymmetric:  # the area of whose floor is not centred
        p += across * on.centres[:, 0]
        floor += across * 0.03
    above = outside if isinstance(roof, OutletCondition) else floor + height * along
    b.state = replace(b.state, p=p)
    assert results.pressure_drop(b) == approx(floor - above, abs=1e-9)
