"""Effective conductivity of a packed bed of glass-like spheres (Zhou, Yu & Zulli 2010, Figs. 8 and 9 of the chapter).

python studies/zhou_2010_etc/study.py
"""

import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from contbed import closures
from contbed.dem import dumps, heat, network
from contbed.dem.heat_pair import IMPACT, STATIC, correction
from contbed.dem.packing import pack
from contbed.dem.particles import Material
from contbed.materials import gas_mixture

HERE = Path(__file__).parent
R, WIDTH, EPS, K_FLUID = 1e-3, 0.026, 0.391, 0.026
BOTTOM, TOP, AREA = 2e-3, 24.7e-3, WIDTH**2
SOFT, REAL = 1e7, 5e10  # modulus of the shared packing and of the material [Pa]
RATIOS = np.geomspace(1, 1000, 13)
MODULI = (1e6, 1e7, 1e8, 1e9, 1e10, 5e10)  # of packings of our own
EXPONENTS = {"none": 0.0, "1/5": IMPACT, "1/3": STATIC}


def shared():
    """Centres of the shared packing [m], settled with E = 10 MPa."""
    return dumps.read_positions(HERE / "packing.csv.gz")


def own(modulus, seed=1):
    """Centres [m] and porosity of a bed of our own, settled and stiffened to a modulus [Pa]."""
    bed = pack(
        (WIDTH, WIDTH), radius=R, count=2500, seed=seed, material=Material(density=1000.0, youngs_modulus=modulus)
    )
    return bed.position, bed.statistics["porosity_core"]


def relative(x, ratios, factor=1.0, paths="cones", k_fluid=K_FLUID, emissivity=None, T=None, eps=EPS):
    """k_e/k_f at ratios k_p/k_f; the slope method between the particles below BOTTOM and above TOP."""
    if paths == "columns":
        pairs = heat.voronoi_pairs(x, (np.zeros(3), np.array([WIDTH, WIDTH, x[:, 2].max() + R])))
    else:
        pairs = heat.near_pairs(x, 3 * R)
    found = []
    for ratio in ratios:
        parts = heat.conductances(pairs, R, heat.Conduction(ratio * k_fluid, k_fluid, eps, factor, paths=paths))
        if emissivity is not None:
            parts["radiation"] = heat.radiation_conductance(pairs, len(x), T, 2 * R, emissivity, eps)
        result = network.between_layers(x, pairs, parts, x[:, 2] < BOTTOM, x[:, 2] > TOP, AREA)
        found.append(result.conductivity / k_fluid)
    return np.array(found)


def correlations(ratios):
    """k_e/k_f of the literature at the porosity of the packing."""
    names = {
        "Zehner-Schluender": closures.conductivity_zehner_schluender,
        "Kunii-Smith": closures.conductivity_kunii_smith,
        "Hashin-Shtrikman, lower": closures.conductivity_hashin_shtrikman_lower,
        "Hashin-Shtrikman, upper": closures.conductivity_hashin_shtrikman_upper,
    }
    return {name: function(k_fluid=1.0, k_solid=ratios, eps=EPS) for name, function in names.items()}


def curves(x):
    """k_e/k_f of the shared packing over RATIOS by treatment."""
    c = {name: correction(SOFT, REAL, exponent) for name, exponent in EXPONENTS.items()}
    found = {f"cones, {name}": relative(x, RATIOS, factor) for name, factor in c.items()}
    return found | {f"columns, {name}": relative(x, RATIOS, c[name], "columns") for name in ("1/5", "1/3")}


def moduli():
    """Rows E, exponent, k_e/k_f at 10, 100 and 1000, from beds settled with each modulus."""
    rows = []
    for modulus in MODULI:
        x, eps = own(modulus)
        for name, exponent in EXPONENTS.items():
            rows.append((modulus, name, *relative(x, (10, 100, 1000), correction(modulus, REAL, exponent), eps=eps)))
    return rows


def loaded(x, moduli):
    """k_e/k_f at ratio 1000 of the shared packing as a real bed of each modulus: r_c ~ E^(-1/3) at the same loads."""
    return np.array([relative(x, (1000,), correction(SOFT, E, STATIC))[0] for E in moduli])


def sizes(x, diameters, ratios):
    """k_e/k_f of beds that are the shared one scaled, E = 50 GPa: r_c/R ~ (rho g R/E)^(1/3) at a fixed geometry."""
    c = correction(SOFT, REAL, STATIC)
    return np.array([relative(x, ratios, c * (d / (2 * R)) ** (1 / 3)) for d in diameters])


def temperatures(x, celsius, k_particle=0.84, emissivity=0.9):
    """k_e [W/m/K] of glass in air with radiation at temperatures [degC]."""
    air = gas_mixture("N2:0.79, O2:0.21", 101325.0, "gri30.yaml")
    out = []
    for T in np.asarray(celsius) + 273.15:
        k_fluid = float(air.conductivity(T))
        ratio = (k_particle / k_fluid,)
        out.append(k_fluid * relative(x, ratio, correction(SOFT, REAL), k_fluid=k_fluid, emissivity=emissivity, T=T)[0])
    return np.array(out)


def plot(found, rows, path):
    figure, panels = plt.subplots(1, 2, figsize=(10.5, 4.8), sharey=True, layout="constrained")
    left, right = panels
    for name, values in correlations(RATIOS).items():
        style = {"Zehner-Schluender": "-", "Kunii-Smith": "--"}.get(name, ":")
        for axes in panels:
            axes.loglog(RATIOS, values, style, color="0.55", lw=1.2, label=name if axes is right else None)
    left.loglog(RATIOS, found["cones, none"], "k-", label="shared bed, 10 MPa")
    colours = plt.get_cmap("plasma")(np.linspace(0.1, 0.85, len(MODULI)))
    for colour, modulus in zip(colours, MODULI, strict=True):
        for axes, wanted, marker in ((left, "none", "o"), (right, "1/5", "o"), (right, "1/3", "x")):
            values = next(row[2:] for row in rows if row[:2] == (modulus, wanted))
            label = f"own bed, {modulus / 1e6:g} MPa" if wanted == "none" else None
            axes.loglog((10, 100, 1000), values, marker, color=colour, ms=5, label=label)
    right.loglog(RATIOS, found["cones, 1/5"], "C0-", label="cones, exponent 1/5 (o)")
    right.loglog(RATIOS, found["cones, 1/3"], "C2-", label="cones, exponent 1/3 (x)")
    right.loglog(RATIOS, found["columns, 1/3"], "C3-", label="columns, exponent 1/3")
    for axes, title in ((left, "contacts as simulated"), (right, "contacts corrected to 50 GPa")):
        axes.set(xlabel="$k_p/k_f$", title=title, ylim=(0.9, 120))
        axes.legend(fontsize=8, frameon=False, loc="upper left")
    left.set_ylabel("$k_e/k_f$")
    figure.savefig(path, dpi=150)


def main():
    x = shared()
    found, rows = curves(x), moduli()
    table = found | correlations(RATIOS)
    with open(HERE / "ratios.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["k_p/k_f", *table])
        writer.writerows([f"{v:.5g}" for v in row] for row in zip(RATIOS, *table.values(), strict=True))
    with open(HERE / "moduli.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["E [Pa]", "correction", "10", "100", "1000"])
        writer.writerows([f"{row[0]:g}", row[1], *(f"{v:.5g}" for v in row[2:])] for row in rows)
    plot(found, rows, HERE / "etc.png")
    print(f"{'k_p/k_f':>24}", *(f"{v:8.3g}" for v in RATIOS[::2]))
    for name, values in table.items():
        print(f"{name:>24}", *(f"{v:8.3f}" for v in values[::2]))
    for row in rows:
        print(f"E {row[0]:8.0e} exponent {row[1]:5}", *(f"{v:7.3f}" for v in row[2:]))
    E = (1e6, 1e7, 1e8, 1e9, 1e10, 5e10)
    print("same loads, ratio 1000:", *(f"{e:.0e} {v:.3f}" for e, v in zip(E, loaded(x, E), strict=True)))
    d = (0.25e-3, 0.5e-3, 2e-3, 10e-3)
    for diameter, values in zip(d, sizes(x, d, (30, 1000)), strict=True):
        print(f"diameter {1e3 * diameter:g} mm, ratios 30 and 1000:", values.round(3))
    t = (75, 500, 1000, 1475)
    for emissivity in (0.9, 0.4):
        print(f"k_e [W/m/K] at {t} degC, emissivity {emissivity}:", temperatures(x, t, emissivity=emissivity).round(4))


if __name__ == "__main__":
    main()
