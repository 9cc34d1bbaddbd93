from tests.scene_text import scene_of, set_keys

"""Scenes for tests of gradients: a moving bed between two streams, on few cells."""

SLIP = """\
[mesh]
type = "line"
length = 0.04
cells = 60

[gas]
density = 0.4345
heat_capacity = 1986.8
conductivity = 0.0345
viscosity = 1.731e-5

[solids.particles]
density = 2000.0
heat_capacity = 800.0
conductivity = 0.8625
diameter = 0.01

[packed_bed]
porosity = 0.6

[closures]
permeability = 1e-7
forchheimer = 0.1
nusselt = 12.0

[heat]

[boundary.left]
gas.velocity = 0.2
solids.particles.velocity = 1e-4
gas.fixed_temperature = 300.0
solids.particles.fixed_temperature = 400.0

[solver]
stabilisation = false
degree = 3
"""


def frozen_results(result, qoi):
    """Results of full solutions on the mesh of a run, as a function of the scene."""
    from contbed.many.derivatives.gradients import picked
    from contbed.packed_bed.plan import Plan
    from contbed.packed_bed.run import run
    from contbed.result import Result

    class OneMesh(Plan):
        """A plan that keeps its mesh."""

        adaptations = 0

    def solve(scene):
        plan = result.plan.with_values(scene)
        found = Result(
            OneMesh(**{name: getattr(plan, name) for name in plan.__dataclass_fields__})
        )
        run(found.plan, found, None, True, None)
        return picked(scene, found.qoi, qoi)

    return solve


def random_scene(seed):
    """A steady bed: line, plane, round bed or box; constant or varying properties;
    plug or computed flow; radiation.
    """
    import numpy as np

    from contbed.loading import from_dict

    random = np.random.default_rng(seed)
    shape = ["line", "rectangle", "axisymmetric", "box"][
        random.choice(4, p=[0.45, 0.25, 0.2, 0.1])
    ]
    length = float(random.uniform(0.1, 0.4))
    across = float(random.uniform(0.02, 0.06))
    mesh = {"type": shape, "length": length}
    mesh["cells"] = {
        "line": 30,
        "rectangle": [10, 5],
        "axisymmetric": [5, 10],
        "box": [6, 3, 3],
    }[shape]
    if shape == "rectangle":
        mesh |= {
            "height": across,
            "shape": str(random.choice(["triangle", "quadrilateral"])),
        }
    elif shape == "axisymmetric":
        mesh["radius"] = across
    elif shape == "box":
        mesh |= {"width": across, "height": across}
    varies = random.random() < 0.5
    gas = {
        "density": 0.6,
        "heat_capacity": 1100.0,
        "conductivity": 0.05,
        "viscosity": 3e-5,
    }
    if varies:
        gas = {"model": "cantera", "composition": "N2:0.79, O2:0.21", "pressure": 1.2e5}
    low, high = ("bottom", "top") if shape == "axisymmetric" else ("left", "right")
    wall = {"line": None, "rectangle": "top", "axisymmetric": "wall", "box": "back"}[
        shape
    ]
    boundary = {
        low: {
            "gas": {
                str(random.choice(["temperature", "fixed_temperature"])): float(
                    random.uniform(300, 400)
                )
            }
        },
        high: {},
    }
    moves = random.random() < 0.5
    counter = bool(moves and random.random() < 0.5)
    boundary[high if counter else low]["solids"] = {
        "particles": {"fixed_temperature": float(random.uniform(600, 900))}
    }
    speed = float(random.uniform(5e-5, 3e-4)) * (-1 if counter else 1) if moves else 0.0
    closures = {
        "nusselt": [8.0, "wakao_kaguei", {"name": "gunn"}][random.choice(3)],
        "conductivity_solids": float(random.uniform(0.3, 2.0)),
    }
    if random.random() < 0.3:
        closures["dispersion"] = {"axial": 0.3, "transverse": 0.1}
    if wall and random.random() < 0.6:
        boundary[wall] = {
            "solids": {
                "particles": {
                    "coefficient": float(random.uniform(20, 90)),
                    "ambient": 500.0,
                }
            }
        }
    if wall and shape != "box" and random.random() < 0.5:
        boundary.setdefault(wall, {})["type"] = "no_slip"
    porosity, diameter = (
        float(random.uniform(0.36, 0.5)),
        float(random.uniform(4e-3, 12e-3)),
    )
    boundary[low]["gas"]["velocity"] = float(random.uniform(0.1, 0.6))
    solid = {
        "density": 2300.0,
        "heat_capacity": 900.0,
        "conductivity": 1.5,
        "diameter": diameter,
    }
    if moves:
        boundary[high if counter else low]["solids"]["particles"]["velocity"] = abs(
            speed
        )
    values = scene_of(
        """
            heat = {}

            [solver]
            degree = 2
            newton_tolerance = 1e-12
            balance_tolerance = 1e-6
        """,
        {
            "mesh": mesh,
            "gas": gas,
            "solids.particles": solid,
            "packed_bed.porosity": porosity,
            "closures": closures,
            "boundary": boundary,
        },
    )
    if varies and random.random() < 0.5:
        solid["heat_capacity"] = [700.0, 0.3]
    if random.random() < 0.25:
        solid["emissivity"] = 0.8
        set_keys(values, 'radiation = { level = "p1" }')
    return from_dict(values)
