"""Materials by name with the sources of their values, for tables of solids and fluids:
`material = "alumina"`.

Properties are polynomials a0 + a1 T + a2 T^2 + ... of T [K], as in a scene. They follow
the values of the source within `error`; where no source gives a property that holds for
the material in general, it is absent and a scene has to give it.
"""

from __future__ import annotations

from dataclasses import dataclass

from contbed.errors import SceneError
from contbed.scene.names import nearest

Coefficients = tuple[float, ...]

_INCROPERA = (
    "Incropera, DeWitt, Bergman, Lavine 2007, Fundamentals of Heat and Mass "
    "Transfer, 6th edition, Wiley"
)
_CHASE = (
    "Chase 1998, NIST-JANAF Thermochemical Tables, 4th edition, as Shomate "
    "equation in the NIST WebBook, SRD 69"
)
_CALLISTER = (
    "Callister 2007, Materials Science and Engineering, 7th edition, Wiley, tables "
    "B.2 and B.3"
)
_BASS = (
    "Bass 1995, AGU Reference Shelf 2, 45-63, doi:10.1029/RF002p0045, mean of all "
    "directions (Hill)"
)
_WAPLES = (
    "Waples, Waples 2004, Nat. Resour. Res. 13, 97-122, "
    "doi:10.1023/B:NARR.0000032647.41046.e7"
)
_HORAI = "Horai 1971, J. Geophys. Res. 76, 1278-1308, doi:10.1029/JB076i005p01278"


@dataclass(frozen=True)
class Material:
    """Properties of a solid or a liquid as coefficients of polynomials, None where a
    scene has to give them.

    `T_range` [K] is where they hold, `error` their largest relative deviation from the
    values of the source.
    """

    name: str
    meaning: str
    phase: str  # solid or fluid
    T_range: tuple[float, float]
    source: str
    density: Coefficients | None = None  # [kg/m3]
    heat_capacity: Coefficients | None = None  # [J/kg/K]
    conductivity: Coefficients | None = None  # [W/m/K]
    viscosity: Coefficients | None = None  # [Pa s]
    youngs_modulus: Coefficients | None = None  # [Pa]
    poisson_ratio: Coefficients | None = None  # [-]
    stiffness_source: str = ""  # of Young's modulus and Poisson's ratio, at 20 degC
    error: float = 0.0

    def at(self, T: float) -> dict[str, float]:
        """Return the properties at a temperature [K]."""
        return {
            name: sum(c * T**n for n, c in enumerate(a))
            for name, a in self.properties().items()
        }

    def properties(self) -> dict[str, Coefficients]:
        """Return the coefficients of the properties that there are, by the keys of a
        scene.
        """
        return {name: a for name in _UNITS if (a := getattr(self, name)) is not None}


_UNITS = {
    "density": "kg/m3",
    "heat_capacity": "J/kg/K",
    "conductivity": "W/m/K",
    "viscosity": "Pa s",
    "youngs_modulus": "Pa",
    "poisson_ratio": "-",
}
# keys that only some models need
_OF_SOLIDS = ("youngs_modulus", "poisson_ratio")

_ALL = (
    Material(
        "alumina", "sintered alpha-Al2O3, 99.5 % and dense; the density is that at 20 "
                   "degC", "solid", (293.0, 1773.0),
        "Munro 1997, J. Am. Ceram. Soc. 80, 1919-1928, "
        "doi:10.1111/j.1151-2916.1997.tb03074.x; NIST SRD 150",
        (3984.0,), (59.9293, 3.2644, -0.00353037, 1.74021e-06, -3.15663e-10),
        (67.007, -0.1562, 0.000157078, -7.17348e-08, 1.23675e-11), error=0.005,
        youngs_modulus=(416e9,), poisson_ratio=(0.231,),
        stiffness_source="NIST SRD 150",
    ),
    Material(
        "silica", "fused silica; the conductivity includes radiation through it", "solid", (300.0, 1200.0),
        f"{_INCROPERA}, table A.2, silicon dioxide, polycrystalline (fused silica)",
        (2220.0,), (-461.048, 6.72848, -0.0114565, 8.91137e-06, -2.56557e-09),
        (0.883934, 0.00240487, -3.32141e-06, 2.90146e-09), error=0.007,
        youngs_modulus=(73e9,), poisson_ratio=(0.17,),
        stiffness_source=_CALLISTER,
    ),
    Material(
        "sand", "grains of alpha quartz; the conductivity is that at 25 degC and falls "
                "with temperature", "solid",
        (298.0, 847.0), f"cp: {_CHASE}; conductivity: {_HORAI}, mean of all "
                        "directions; density of the crystal",
        (2650.0,), (-99.399, 4.1821, -0.00539661, 2.80112e-06), (7.69,), error=0.001,
        youngs_modulus=(95.6e9,), poisson_ratio=(0.08,),
        stiffness_source=_BASS,
    ),
    Material(
        "steel", "stainless steel AISI 304", "solid", (300.0, 1500.0), f"{_INCROPERA}, "
                                                                       "table A.1",
        (7900.0,), (357.687, 0.513894, -0.000382372, 1.22926e-07), (9.86617, 0.0175964, -2.04084e-06), error=0.01,
        youngs_modulus=(193e9,), poisson_ratio=(0.30,),
        stiffness_source=_CALLISTER,
    ),
    Material(
        "iron_ore", "dense grains of hematite, Fe2O3; the conductivity is that at 25 "
                    "degC; pellets are porous", "solid",
        (298.0, 950.0), f"cp: {_CHASE}; conductivity: {_HORAI}, hematite; density of "
                        "the mineral",
        (5260.0,), (214.135, 1.997, -0.00199508, 8.87077e-07), (11.28,), error=0.01,
        youngs_modulus=(238e9,), poisson_ratio=(0.31,),
        stiffness_source=_BASS,
    ),
    Material(
        "glass", "soda-lime glass, values at 300 K", "solid", (273.0, 373.0),
        f"{_INCROPERA}, table A.3, glass, plate (soda lime)", (2500.0,), (750.0,), (1.4,),
        youngs_modulus=(69e9,), poisson_ratio=(0.23,),
        stiffness_source=_CALLISTER,
    ),
    Material(
        "granite", "Barre granite at 300 K; heat capacity and conductivity of granites "
                   "beyond", "solid", (298.0, 846.0),
        f"density and cp at 300 K: {_INCROPERA}, table A.3; cp over temperature: "
        f"{_WAPLES}; conductivity: Miao, Li, Chen 2014, J. Therm. Anal. Calorim. 115, "
        "1057-1063, doi:10.1007/s10973-013-3427-2, as 1/(0.24094 + 4.6019e-4 T)",
        (2630.0,), (70.3214921, 3.14207256, -2.91737444e-03, 9.11868078e-07),
        (3.6310095, -3.88087227e-03, 1.74697866e-06), error=0.01,
    ),
    Material(
        "quartzite", "Sioux quartzite; cp of alpha quartz; the conductivity is that at "
                     "300 K and falls with temperature", "solid", (298.0, 847.0),
        f"density and conductivity: {_INCROPERA}, table A.3; cp: {_CHASE}",
        (2640.0,), (-99.399, 4.1821, -0.00539661, 2.80112e-06), (5.38,), error=0.001,
    ),
    Material(
        "concrete", "dry, of siliceous aggregate; the conductivity is the lower limit",
        "solid", (293.0, 873.0),
        "EN 1992-1-2:2004, Design of concrete structures, structural fire design, "
        "section 3.3",
        (2300.0,),
        (1972.47001, -9.22335241, 0.0269002556, -3.08069669e-05, 1.23591667e-08),
        (1.77401223, -1.671391e-03, 5.7e-07), error=0.02,
    ),
    Material(
        "coal_ash", "mineral matter of coal; density and conductivity vary too much to "
                    "be given", "solid",
        (273.0, 1273.0), "Kirov 1965, as used by Merrick 1983, Fuel 62, 540-546",
        None, (593.9341, 0.586),
    ),
    Material(
        "FCC", "fluid cracking catalyst, density of the porous particle", "solid", (280.0, 1000.0),
        "McKeen, Pugsley 2003, Powder Technol. 129, 139-152, "
        "doi:10.1016/S0032-5910(02)00294-2", (1400.0,),
    ),
    Material(
        "solar_salt", "molten salt, 60 % NaNO3 and 40 % KNO3 by mass", "fluid", (533.0, 873.0),
        "Zavoico 2001, Sandia report SAND2001-2100, section 1.6, doi:10.2172/786629",
        (2263.7234, -0.636), (1396.0182, 0.172), (0.3911015, 1.9e-4),
        (7.55147595e-02, -2.7760398e-04, 3.4888693e-07, -1.474e-10),
    ),
)  # fmt: skip

MATERIALS = {material.name: material for material in _ALL}


def material(name: str, phase: str) -> Material:
    """Return the material of a name.

    Raises
    ------
    SceneError : there is none, or it is of another phase
    """
    known = [entry.name for entry in _ALL if entry.phase == phase]
    if name not in known:
        other = (
            f" is a {MATERIALS[name].phase}, not a {phase};"
            if name in MATERIALS
            else " is not in the library;"
        )
        raise SceneError(f"material {name!r}{other} {nearest(name, known)}")
    return MATERIALS[name]


def data_sheet(name: str) -> str:
    """Return what is known of a material as text."""
    found = MATERIALS[name]
    low, high = found.T_range
    lines = [f"{name} - {found.meaning}", f"    {found.phase}, {low:g} to {high:g} K"]
    properties = found.properties()
    for key, unit in _UNITS.items():
        if key in properties:
            ends = (
                " to ".join(f"{found.at(T)[key]:.4g}" for T in (low, high))
                if len(properties[key]) > 1
                else ""
            )
            text = ends or f"{properties[key][0]:g}"
            lines.append(
                f"    {key}: {text} {unit}; coefficients "
                f"{', '.join(f'{a:g}' for a in properties[key])}"
            )
        elif key not in _OF_SOLIDS and (found.phase == "fluid" or key != "viscosity"):
            lines.append(
                f"    {key}: not in the library, to be given in the scene [{unit}]"
            )
    if found.error:
        lines.append(f"    polynomials within {100 * found.error:g} % of the source")
    lines.append(f"    source: {found.source}")
    if found.stiffness_source:
        lines.append(f"    source of the stiffness: {found.stiffness_source}")
    return "\n".join(lines)
