"""Rates of reactions of particles with the gas of a fluidized bed: char, moisture,
limestone.

Char of diameter d_0 that is fed to a mixed bed is there in all stages of its burning.
With the surface and the film of its fresh size for all of them, population and particle
are related by two numbers, `Population`:

    shrinking   d^3 ~ carbon left at constant density:  surface 8/d_0 per volume of char, film of 0.8 d_0
    density     constant size, carbon of falling density: surface 12/d_0 per volume of char of full density, film of d_0

They are exact for a reaction of first order, a constant Sherwood number and carbon that
leaves by reaction alone: the number of particles of size d is ~ 1/|d'|, |d'| ~
1/(1/k + d/(Sh D)), and that cancels in the mean of the rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry.power_law import PowerLaw
from contbed.chemistry.thermo import R_GAS

ATM, BAR = 101325.0, 1e5  # [Pa]


@dataclass(frozen=True)
class Population:
    """Char of all stages of burning."""

    surface: float  # times 1/d_0: surface per volume of unburnt char
    film: float  # times d_0: diameter that the film belongs to


POPULATIONS = {"shrinking": Population(8.0, 0.8), "density": Population(12.0, 1.0)}

CHAR_LAWS: dict[str, dict[str, PowerLaw]] = {
    "char_combustion": {
        "field": PowerLaw(
            "field", "C + O2 -> CO2", 595.0, 1.0, 17967.0, {"O2": 1.0}, (950.0, 1650.0),
            "Field 1969, Combust. Flame 13, 237-252, doi:10.1016/0010-2180(69)90002-9", unit="m/s of carbon",
        ),
    },
    "char_steam": {
        "barrio": PowerLaw(
            "barrio", "C + H2O <-> CO + H2", 2.62e8, 0.0, 237e3 / R_GAS, {"H2O": 0.57}, (1020.0, 1225.0),
            "Barrio, Gobel, Risnes, Henriksen, Hustad, Sorensen 2001, in Bridgwater "
            "(ed.), Progress in Thermochemical "
            "Biomass Conversion, 32-46, doi:10.1002/9780470694954.ch2", unit="1/s of carbon, bar",
        ),
    },
    "char_CO2": {
        "barrio": PowerLaw(
            "barrio", "C + CO2 <-> 2 CO", 3.1e6, 0.0, 215e3 / R_GAS, {"CO2": 0.38}, (1020.0, 1275.0),
            "Barrio, Hustad 2001, in Bridgwater (ed.), Progress in Thermochemical "
            "Biomass Conversion, 47-60, "
            "doi:10.1002/9780470694954.ch3", unit="1/s of carbon, bar",
        ),
    },
    "char_H2": {
        "wen": PowerLaw(
            "wen", "C + 2 H2 <-> CH4", float(np.exp(-7.087)) / (ATM / BAR), 0.0, 8078.0, {"H2": 1.0}, (900.0, 1400.0),
            "Wen, Chen, Onozaki 1982, DOE/MC/16474-1390", unit="1/s of carbon, bar",
        ),
    },
}  # fmt: skip
"""Combustion per outer surface [m/s]; gasification per carbon, partial pressures in bar [1/s]."""

CALCINATION = PowerLaw(
    "silcox",
    "CaCO3 <-> CaO + CO2",
    1.22 / ATM,
    0.0,
    4026.0,
    {},
    (900.0, 1400.0),
    "Silcox, Kramlich, Pershing 1989, Ind. Eng. Chem. Res. 28, 155-160, "
    "doi:10.1021/ie00086a005",
    unit="mol/m2/s/Pa",
)

SULPHATION = PowerLaw(
    "borgwardt",
    "CaO + SO2 + 0.5 O2 -> CaSO4",
    490.0,
    0.0,
    17500 * 4.184 / R_GAS,
    {"SO2": 1.0},
    (1030.0, 1450.0),
    "Rajan, Wen 1980, AIChE J. 26, 642-655, doi:10.1002/aic.690260416, after Borgwardt "
    "1970",
    unit="1/s per cm2/g",
)

T_850C = 1123.15  # [K]
SULPHATE_REDUCTION = PowerLaw(
    "kikuchi",
    "CaSO4 + CO <-> CaO + SO2 + CO2",
    float(np.exp(57.8e3 * 4.184 / R_GAS / T_850C)),
    0.0,
    57.8e3 * 4.184 / R_GAS,
    {"CO": 1.0},
    (1073.0, 1473.0),
    "Kikuchi, Iwasaki, Hatsuyama, Morita 1983, J. Fuel Soc. Jpn. 62, 204-210 (J-STAGE "
    "jie1922/62/3): orders of the "
    "first step, activation energy of the slow second one, 242 kJ/mol; Laasri, "
    "Carrillo Garcia, Chaouki 2024, "
    "doi:10.1007/s10163-024-01968-w, find 140 kJ/mol; no measurement of the constant "
    "itself, which the scene gives",
    unit="over that at 850 degC",
)
"""Growth with temperature alone: no published rate constant could be confirmed, so that a scene gives its own."""


def carbon_per_oxygen(T: Any) -> Any:
    """Moles of carbon that one mole of O2 burns, phi = (2 + 2 beta)/(2 + beta),
    CO/CO2 = beta = 2512 exp(-6240/T).

    Arthur 1951, Trans. Faraday Soc. 47, 164-178, doi:10.1039/TF9514700164; 730 to 1170
    K.
    """
    beta = 2512.0 * np.exp(-6240.0 / T)
    return (2.0 + 2.0 * beta) / (2.0 + beta)


def char_combustion(k: Any, film: Any, phi: Any) -> Any:
    """Carbon burnt per surface and concentration of O2 [m/s]: kinetics `k` and
    film [m/s] in series, phi C per O2.

    phi/(phi/k + 1/film); film -> inf: k. k -> inf: phi film.
    """
    return phi / (phi / k + 1.0 / film)


def in_series(a: Any, b: Any) -> Any:
    """Return 1/(1/a + 1/b), two resistances in series."""
    return a * b / (a + b)


# names of laws that bubbling beds have for fuel and limestone
OF_BOILERS = {name for laws in CHAR_LAWS.values() for name in laws} | {
    law.name for law in (CALCINATION, SULPHATION, SULPHATE_REDUCTION)
}

VOLUMES = {
    "O2": 16.3,
    "CO": 18.0,
    "CO2": 26.9,
    "H2O": 13.1,
    "H2": 6.12,
    "CH4": 25.14,
    "SO2": 41.8,
}
_N2 = 18.5


def diffusion_in_nitrogen(name: str, molar_mass: float, T: Any, p: float) -> Any:
    """Diffusion coefficient [m2/s] of a gas of `molar_mass` [kg/mol] in N2 at p [Pa].

    1.43e-7 T^1.75 / (p/bar M^(1/2) (v^(1/3) + v_N2^(1/3))^2), M in g/mol the harmonic
    mean of both. Fuller, Schettler, Giddings 1966, Ind. Eng. Chem. 58 (5), 18-27,
    doi:10.1021/ie50677a007; below 10 bar.
    """
    mean = 2.0 / (1.0 / (1e3 * molar_mass) + 1.0 / 28.0134)
    size = (VOLUMES[name] ** (1 / 3) + _N2 ** (1 / 3)) ** 2
    return 1.43e-7 / (p / BAR * mean**0.5 * size) * T**1.75


def lime_surface(T: Any) -> Any:
    """Surface of lime that takes up SO2 [cm2/g]: grows with calcination, falls with
    sintering above 1248 K.

    min(35.9 T - 3.67e4, 5.6e4 - 38.4 T), corner rounded over some 10 K, and not below 0
    (T < 1022 K, T > 1458 K). Rajan, Wen 1980, AIChE J. 26, 642-655,
    doi:10.1002/aic.690260416 (branches change at 1253 K, with a jump of 5 %).
    """
    up, down = 35.9 * T - 3.67e4, 5.6e4 - 38.4 * T
    lower = 0.5 * (up + down - ((up - down) ** 2 + 400.0**2) ** 0.5)
    return positive(lower, 50.0)


def positive(x: Any, width: Any) -> Any:
    """Return x for x >> width and 0 for x << -width, smooth between."""
    return 0.5 * (x + (x * x + width * width) ** 0.5)
