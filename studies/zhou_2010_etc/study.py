"""Effective conductivity of a packed bed of glass-like spheres (Zhou, Yu & Zulli
2010, Figs. 8 and 9).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed import closures
from contbed.dem import heat, network
from contbed.dem.heat_pair import IMPACT, STATIC, correction
from contbed.dem.packing import Packing, pack
from contbed.dem.particle_tables import read_table
from contbed.dem.particles import Material
from contbed.materials import gas_mixture
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
R, WIDTH, EPS, K_FLUID = 1e-3, 0.026, 0.391, 0.026
BOTTOM, TOP, AREA = 2e-3, 24.7e-3, WIDTH**2
SOFT, REAL = 1e7, 5e10  # modulus of the shared packing and of the material [Pa]
COUNT = 2500  # of the shared packing
RATIOS = np.geomspace(1, 1000, 13)
POINTS = (10, 100, 1000)  # ratios of packings of our own
MODULI = (1e6, 1e7, 1e8, 1e9, 1e10, 5e10)  # of packings of our own
EXPONENTS = {"none": 0.0, "1/5": IMPACT, "1/3": STATIC}


def shared() -> Any:
    """Centres of the shared packing [m], settled with E = 10 MPa."""
    return read_table(HERE / "packing.csv.gz").x


def own(modulus: float, seed: int = 1, count: int = COUNT, **how: Any) -> Packing:
    """Settle and stiffen a bed of our own to a modulus [Pa], on a floor that grows
    with the number of spheres.
    """
    width, material = (
        WIDTH * (count / COUNT) ** 0.5,
        Material(density=1000.0, youngs_modulus=modulus),
    )
    return pack(
        (width, width), radius=R, count=count, seed=seed, material=material, **how
    )


def relative(
    x: Any,
    ratios: Any,
    factor: float = 1.0,
    paths: str = "cones",
    k_fluid: float = K_FLUID,
    emissivity: float | None = None,
    T: float = 300.0,
    eps: float = EPS,
    area: float = AREA,
) -> Any:
    """k_e/k_f at ratios k_p/k_f; the slope method between the particles below BOTTOM
    and above TOP.
    """
    if paths == "columns":
        pairs = heat.voronoi_pairs(
            x, (np.zeros(3), np.array([WIDTH, WIDTH, x[:, 2].max() + R]))
        )
    else:
        pairs = heat.near_pairs(x, 3 * R)
    found = []
    for ratio in ratios:
        parts = heat.conductances(
            pairs,
            R,
            heat.Conduction(ratio * k_fluid, k_fluid, eps, factor, paths=paths),
        )
        if emissivity is not None:
            parts["radiation"] = heat.radiation_conductance(
                pairs, len(x), T, 2 * R, emissivity, eps
            )
        result = network.between_layers(
            x, pairs, parts, x[:, 2] < BOTTOM, x[:, 2] > TOP, area
        )
        found.append(result.conductivity / k_fluid)
    return np.array(found)


def reference(ratios: Any) -> dict[str, Any]:
    """k_e/k_f of the literature at the porosity of the packing."""
    names = {
        "Zehner-Schluender": closures.conductivity_zehner_schluender,
        "Kunii-Smith": closures.conductivity_kunii_smith,
        "Hashin-Shtrikman, lower": closures.conductivity_hashin_shtrikman_lower,
        "Hashin-Shtrikman, upper": closures.conductivity_hashin_shtrikman_upper,
    }
    return {
        name: function(k_fluid=1.0, k_solid=ratios, eps=EPS)
        for name, function in names.items()
    }


def curves(x: Any) -> dict[str, Any]:
    """k_e/k_f of the shared packing over RATIOS by treatment."""
    c = {name: correction(SOFT, REAL, exponent) for name, exponent in EXPONENTS.items()}
    found = {
        f"cones, {name}": relative(x, RATIOS, factor) for name, factor in c.items()
    }
    return found | {
        f"columns, {name}": relative(x, RATIOS, c[name], "columns")
        for name in ("1/5", "1/3")
    }


def moduli() -> list[tuple[Any, ...]]:
    """Rows E, exponent, k_e/k_f at POINTS, from beds settled with each modulus."""
    return [(modulus, *row) for modulus in MODULI for row in corrected(own(modulus))]


def corrected(bed: Packing) -> list[tuple[Any, ...]]:
    """Rows exponent, k_e/k_f at POINTS, of a bed that is corrected to the modulus of
    the material.
    """
    eps, area = bed.statistics["porosity_core"], float(np.prod(bed.domain.upper[:2]))
    factors = {
        name: correction(bed.material.youngs_modulus, REAL, exponent)
        for name, exponent in EXPONENTS.items()
    }
    return [
        (name, *relative(bed.position, POINTS, factor, eps=eps, area=area))
        for name, factor in factors.items()
    ]


def loaded(x: Any, moduli: Sequence[float]) -> Any:
    """k_e/k_f at ratio 1000 of the shared packing as a real bed of each modulus: r_c
    ~ E^(-1/3) at the same loads.
    """
    return np.array(
        [relative(x, (1000,), correction(SOFT, E, STATIC))[0] for E in moduli]
    )


def sizes(x: Any, diameters: Sequence[float], ratios: Sequence[float]) -> Any:
    """k_e/k_f of beds that are the shared one scaled, E = 50 GPa: r_c/R ~ (rho g
    R/E)^(1/3) at a fixed geometry.
    """
    c = correction(SOFT, REAL, STATIC)
    return np.array(
        [relative(x, ratios, c * (d / (2 * R)) ** (1 / 3)) for d in diameters]
    )


def temperatures(
    x: Any, celsius: Sequence[float], k_particle: float = 0.84, emissivity: float = 0.9
) -> Any:
    """k_e [W/m/K] of glass in air with radiation at temperatures [degC]."""
    air = gas_mixture("N2:0.79, O2:0.21", 101325.0, "gri30.yaml")
    out = []
    for T in np.asarray(celsius) + 273.15:
        k_fluid = float(air.conductivity(T))
        ratio = (k_particle / k_fluid,)
        out.append(
            k_fluid
            * relative(
                x,
                ratio,
                correction(SOFT, REAL),
                k_fluid=k_fluid,
                emissivity=emissivity,
                T=T,
            )[0]
        )
    return np.array(out)


def compute() -> Tables:
    """Conductivities over ratio and modulus; prints those over load, size and
    temperature.
    """
    x = shared()
    columns = {"k_p/k_f": RATIOS, **curves(x), **reference(RATIOS)}
    E, d, t = MODULI, (0.25e-3, 0.5e-3, 2e-3, 10e-3), (75, 500, 1000, 1475)
    print(
        "same loads, ratio 1000:",
        *(f"{e:.0e} {v:.3f}" for e, v in zip(E, loaded(x, E), strict=True)),
    )
    for diameter, values in zip(d, sizes(x, d, (30, 1000)), strict=True):
        print(f"diameter {1e3 * diameter:g} mm, ratios 30 and 1000:", values.round(3))
    for emissivity in (0.9, 0.4):
        print(
            f"k_e [W/m/K] at {t} degC, emissivity {emissivity}:",
            temperatures(x, t, emissivity=emissivity).round(4),
        )
    own_beds = {
        "E [Pa]": "g",
        "correction": "",
        **dict.fromkeys(map(str, POINTS), ".5g"),
    }
    return {
        "ratios": Table.from_columns(columns, ".5g"),
        "moduli": Table(own_beds, moduli()),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """k_e/k_f over k_p/k_f without and with corrected contacts, beside correlations
    in grey.
    """
    found, own_beds = tables["ratios"], tables["moduli"]
    ratio = found["k_p/k_f"]
    figure, panels = gallery.figure(1, 2, size=(10.5, 4.8), sharey=True)
    left, right = panels
    for name, style in zip(reference(1.0), ("-", "--", ":", ":"), strict=True):
        for axes in panels:
            axes.loglog(
                ratio,
                found[name],
                style,
                color="0.55",
                lw=1.2,
                label=name if axes is right else None,
            )
    left.loglog(ratio, found["cones, none"], "k-", label="shared bed, 10 MPa")
    for colour, modulus in zip(
        gallery.shades(len(MODULI), "plasma", 0.1), MODULI, strict=True
    ):
        for axes, wanted, marker in (
            (left, "none", "o"),
            (right, "1/5", "o"),
            (right, "1/3", "x"),
        ):
            row = own_beds.where({"E [Pa]": modulus, "correction": wanted})
            label = f"own bed, {modulus / 1e6:g} MPa" if wanted == "none" else None
            axes.loglog(
                POINTS,
                [row[f"{at}"][0] for at in POINTS],
                marker,
                color=colour,
                ms=5,
                label=label,
            )
    right.loglog(
        ratio, found["cones, 1/5"], color=gallery.BLUE, label="cones, exponent 1/5 (o)"
    )
    right.loglog(
        ratio, found["cones, 1/3"], color=gallery.GREEN, label="cones, exponent 1/3 (x)"
    )
    right.loglog(
        ratio,
        found["columns, 1/3"],
        color=gallery.VERMILION,
        label="columns, exponent 1/3",
    )
    for axes, title in (
        (left, "contacts as simulated"),
        (right, "contacts corrected to 50 GPa"),
    ):
        axes.set(xlabel="$k_p/k_f$", title=title, ylim=(0.9, 120))
        axes.legend(loc="upper left")
    left.set_ylabel("$k_e/k_f$")
    return {"etc": figure}
