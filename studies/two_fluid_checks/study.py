"""Check cases of the two-fluid model: computed beside exact, with tolerance and time.

python studies/two_fluid_checks/study.py [NAME ...]
"""

import csv
import math
import sys
import time
from pathlib import Path

from scipy.optimize import brentq

import contbed as cb
from contbed import closures

HERE = Path(__file__).parent
COLUMNS = ("case", "quantity", "computed", "exact", "deviation", "allowed", "passed", "CPU s")


def cooled(scene):
    """Granular temperature after collisions and drag have acted, closed form."""
    solid, start, gas = scene.solid, scene.initial, scene.gas
    s, t = start.eps_s, scene.time.end
    g0 = closures.g0_sinclair_jackson(s, solid.packing)
    b = closures.granular_dissipation_lun(s, g0, solid.restitution) / (1.5 * s * solid.diameter)
    root = start.theta**0.5
    if scene.two_fluid.drag == "none":
        return start.theta / (1 + b * root * t / 2) ** 2
    beta = closures.drag_wen_yu(0.0, 1 - s, solid.diameter, gas.viscosity)
    a = 2 * beta / (s * solid.density)
    fallen = math.exp(-a * t / 2)
    return (root * fallen / (1 + b * root / a * (1 - fallen))) ** 2 if b else (root * fallen) ** 2


def slip(scene):
    """Velocity of the gas past particles whose weight in the suspension it carries."""
    eps, gas, solid = 1 - scene.initial.eps_s, scene.gas, scene.solid
    law = closures.get(str(scene.two_fluid.drag), "drag")

    def missing(u):
        beta = law(eps * gas.density * u * solid.diameter / gas.viscosity, eps, solid.diameter, gas.viscosity)
        return beta * u - eps * (1 - eps) * (solid.density - gas.density) * scene.two_fluid.gravity

    return brentq(missing, 1e-6, 10.0, xtol=1e-14)


def heated(scene):
    """Temperature of the gas that hot particles have warmed in a closed suspension."""
    gas, solid, start, heat = scene.gas, scene.solid, scene.initial, scene.heat
    s = start.eps_s
    exchange = 6 * s * heat.nusselt * heat.conductivity_gas / solid.diameter**2
    warm, cool = (1 - s) * gas.density * heat.heat_capacity_gas, s * solid.density * heat.heat_capacity_solid
    gap = math.exp(-exchange * (1 / warm + 1 / cool) * scene.time.end)
    return start.T_gas + (start.T_solid - start.T_gas) * cool / (warm + cool) * (1 - gap)


def upper(scene):
    """Clear water above the particles."""
    return scene.mesh.length - 4.60966e-3 * scene.time.end


def lower(scene):
    """Top of the sediment."""
    return 9.21932e-4 * scene.time.end


# quantity, exact value or function of the scene, allowed deviation, of the value unless "absolute"
CASES = {
    "cooling": [("theta_final", cooled, 1e-3)],
    "cooling_drag": [("theta_final", cooled, 1e-3)],
    "shear": [("theta_over_s2d2", 2.057972, 1e-3)],
    "uniform_wenyu": [("slip_velocity", slip, 1e-6), ("mass_drift_relative", 0.0, 1e-12)],
    "uniform_syamlal": [("slip_velocity", slip, 1e-6), ("mass_drift_relative", 0.0, 1e-12)],
    "uniform_gidaspow": [("slip_velocity", slip, 1e-6), ("mass_drift_relative", 0.0, 1e-12)],
    "slip": [("slip_velocity", slip, 1e-8)],
    "heating": [("T_gas_mean [K]", heated, 1e-11)],
    "fixed_bed": [("max_velocity", 0.0, 1e-10)],
    "rest": [("max_velocity", 0.0, 1e-10), ("mass_drift_relative", 0.0, 1e-12)],
    "settling": [("front_position_m", upper, 1e-2), ("lower_front_position_m", lower, 1e-2),
                 ("mass_drift_relative", 0.0, 1e-12)],
    "riemann": [("eps_star", 0.01412995, 1e-3), ("shock_speed", 1.18869463, 1e-2)],
    "crossing": [("mass_drift_relative", 0.0, 1e-12)],
    "closed_box_jj": [("mass_drift_relative", 0.0, 1e-12)],
    "developed": [("pressure_gradient_Pa_m", 894.51612, 1e-5), ("u_solid_centre", 1.1693291, 1e-5),
                  ("u_solid_wall", 1.4396601, 1e-5), ("theta_wall", 0.28117189, 1e-5),
                  ("eps_solid_centre", 0.057977764, 1e-5)],
}  # fmt: skip


def rows(name):
    """One row for each quantity of a case."""
    scene = cb.load(HERE / f"{name}.toml")
    start = time.process_time()
    qoi = cb.run(scene).qoi
    seconds = time.process_time() - start
    for quantity, known, allowed in CASES[name]:
        exact = known(scene) if callable(known) else known
        deviation = abs(qoi[quantity] - exact) / (abs(exact) or 1.0)
        yield name, quantity, qoi[quantity], exact, deviation, allowed, deviation <= allowed, seconds


def main(names):
    found = []
    print("{:18}{:24}{:>16}{:>16}{:>11}{:>10}  {:7}{:>7}".format(*COLUMNS))
    for name in names:
        for row in rows(name):
            found.append(row)
            print("{:18}{:24}{:16.9g}{:16.9g}{:11.2g}{:10.0e}  {!s:7}{:7.1f}".format(*row), flush=True)
    if set(names) == set(CASES):
        with (HERE / "results.csv").open("w", newline="") as file:
            table = csv.writer(file)
            table.writerow(COLUMNS)
            table.writerows((*row[:7], f"{row[7]:.2g}") for row in found)


if __name__ == "__main__":
    main(sys.argv[1:] or list(CASES))
