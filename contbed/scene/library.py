"""Materials by name with the sources of their values, for tables of solids and fluids:
`material = "alumina"`.

Properties are polynomials a0 + a1 T + a2 T^2 + ... of T [K], as in a scene. They follow
the values of the source within `error`; where no source gives a property that holds for
the material in general, it is absent and a scene has to give it. The materials stand in
`materials.toml` beside this file.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

from contbed.errors import SceneError
from contbed.scene.names import nearest

Coefficients = tuple[float, ...]


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


def _read() -> dict[str, Material]:
    """Return the materials of `materials.toml` beside this file by name."""
    file = Path(__file__).with_name("materials.toml")
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    found = {}
    for name, table in content["materials"].items():
        for key in ("T_range", *_UNITS):
            if key in table:
                table[key] = tuple(map(float, table[key]))
        for key in ("source", "stiffness_source"):
            table[key] = table.get(key, "").format_map(content["sources"])
        found[name] = Material(name, **table)
    return found


MATERIALS = _read()


def material(name: str, phase: str) -> Material:
    """Return the material of a name.

    Raises
    ------
    SceneError : there is none, or it is of another phase
    """
    known = [entry.name for entry in MATERIALS.values() if entry.phase == phase]
    if name not in known:
        other = (
            f" is a {MATERIALS[name].phase}, not a {phase};"
            if name in MATERIALS
            else " is not in the library;"
        )
        real = (
            '; or give model = "coolprop" and a name such as "Water"'
            if phase == "fluid"
            else ""
        )
        raise SceneError(f"material {name!r}{other} {nearest(name, known)}{real}")
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
