"""Flow beside no-slip walls on automatic meshes and on given cells: the layer of
Brinkman and its estimated error.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import contbed as cb
from contbed.loading import from_dict, loads
from tests.scene_text import scene_of

H, U, K, EPS = 0.02, 0.5, 1e-6, 0.4


def channel(**mesh):
    """Darcy-Brinkman flow between two plates that are twelve layers apart; no
    inertia.
    """
    return from_dict(
        scene_of(
            """
                gas = { density = 1e-6, viscosity = 1.8e-5 }
                solids = { particles = { diameter = 0.005 } }
                output = { plots = false, fields = false }

                [boundary]
                bottom = { type = "no_slip" }
                top = { type = "no_slip" }

                [closures]
                forchheimer = 0.0
            """,
            {
                "mesh": {"type": "rectangle", "length": 0.1, "height": H} | mesh,
                "packed_bed.porosity": EPS,
                "boundary.left.gas.velocity": U,
                "closures.permeability": K,
            },
        )
    )


def test_an_automatic_mesh_resolves_the_layer():
    """u/u_c = 1 - cosh(y/d)/cosh(H/2d) with d = sqrt(K/eps), at the outlet: within the
    estimate, which is below 1e-3 of the velocity at the inlet.
    """
    result = cb.run(channel())
    layer = np.sqrt(K / EPS)
    centre = U / (1.0 - 2.0 * layer / H * np.tanh(H / (2.0 * layer)))
    assert result.qoi["estimated_error_velocity"] <= 1e-3
    assert result.qoi["u_max_outlet"] == pytest.approx(
        centre * (1.0 - 1.0 / np.cosh(H / (2.0 * layer))), rel=1e-3
    )
    space, u = result.nodal["u"]
    x, y = space.points
    out = np.flatnonzero(x == x.max())
    exact = centre * (
        1.0 - np.cosh((y[out] - H / 2) / layer) / np.cosh(H / (2.0 * layer))
    )
    assert np.abs(u[0, out] - exact).max() <= 1e-3 * U
    assert not [text for text in result.warnings if "velocity" in text]


def test_given_cells_that_miss_the_layer_are_told():
    """4 x 4 cells, three layers wide each: the warning says so and names the cells
    needed.
    """
    result = cb.run(channel(cells=(4, 4)))
    assert result.qoi["estimated_error_velocity"] > 0.1
    text = next(text for text in result.warnings if "velocity" in text)
    assert "most at " in text
    assert "leave out mesh.cells" in text
    assert "graded cells needed are about" in text


AT_REST = """
mesh = { type = "line", length = 0.1, cells = CELLS }
gas = { density = 1.2, viscosity = 1.8e-5, heat_capacity = 1005, conductivity = 0.026 }
solids.beads = { diameter = 5e-4, density = 2600, heat_capacity = 800, conductivity = 1 }
packed_bed.porosity = 0.42
closures = { nusselt = 10, conductivity_gas = 0.0, conductivity_solids = 0.16 }
heat = {}
boundary.left = { type = "wall", temperature = 380 }
boundary.right = { type = "wall" }
initial.temperature = 300
time.end = 1
"""


@pytest.mark.parametrize("cells", [4, 10, 40, 80, 160])
def test_heat_that_the_nodes_of_a_wall_take_at_once(cells):
    """Into a half space go 2 k dT (t C/(pi k))^(1/2). A warning says within 10 % of the
    heat by how much cells that are too thick take more; others are right within 1 %.
    """
    result = cb.run(loads(AT_REST.replace("CELLS", str(cells))))
    capacity = 0.58 * 2600 * 800 + 0.42 * 1.2 * 1005
    exact = 2 * 80 * np.sqrt(0.16 * capacity / np.pi)
    true = result.qoi["heat_left_W"] / exact
    found = [text for text in result.warnings if "heat through the wall" in text]
    if cells == 160:
        assert not found and true == pytest.approx(1.0, abs=0.01)
        return
    number, unit = re.search(r"is about (\S+) (times|%)?", found[0]).groups()
    said = float(number) if unit == "times" else 1.0 + float(number[:-1]) / 100.0
    assert said == pytest.approx(true, rel=0.1)
