"""What all tables [solids.NAME] share: a material of the library, and the properties
of the particles' material.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, TypeVar

from pydantic import ValidationInfo, field_validator, model_validator

from contbed.scene.property_table import constant_at, range_of
from contbed.scene.quantities import Density, Length, Table, Temperature
from contbed.scene.tables import from_library, names_material

FILLED_AT = 293.15  # [K] for the mass of particles whose density is a table

_FROM_MATERIAL = (
    "density",
    "heat_capacity",
    "conductivity",
    "youngs_modulus",
    "poisson_ratio",
)

_TABULATED = ("density", "heat_capacity", "conductivity")
_VARYING = (dict, list, tuple)  # how properties that vary are written

Phase = TypeVar("Phase")


class SolidPhase(Table):
    """Particles whose properties may come from a material of the library.

    A model adds its own keys, and declares a key again where it needs one or has
    another default for it. `varies` names the properties that may depend on
    temperature: as lists of coefficients a0 + a1 T + a2 T^2 + ..., or tables. The
    density does not: particles keep their mass, and the bed its porosity.
    """

    varies: ClassVar[frozenset[str]] = frozenset()

    material: str | None = None
    """solid of the library; keys that are given replace its properties"""
    material_temperature: Temperature | None = None
    """at which properties that vary with temperature are taken as constants"""
    diameter: Length | None = None
    """diameter of the particles"""
    density: Density | None = None
    """density of the solid material; a table over temperature is taken at
    material_temperature, else at 20 degC"""

    @model_validator(mode="before")
    @classmethod
    def _material(cls, values: Any) -> Any:
        """Return the table with the properties of its material.

        Raises
        ------
        ValueError : an unknown material, or a property that varies where the model
            takes constants only
        """
        if (
            isinstance(values, dict)
            and "material_temperature" in values
            and "material" not in values
            and not any(isinstance(values.get(key), _VARYING) for key in _TABULATED)
        ):
            raise ValueError(
                "material_temperature has no use without material, or a property that "
                "varies with temperature"
            )
        if not names_material(values):
            return values
        properties = from_library("solid", values)
        known = {
            key: properties[key]
            for key in _FROM_MATERIAL
            if key in properties and key in cls.model_fields
        }
        fixed = {key: known[key] for key in known if key not in cls.varies}
        _require_constants(fixed, values)
        return known | values

    @field_validator(*_TABULATED, mode="before", check_fields=False)
    @classmethod
    def _constant(cls, given: Any, info: ValidationInfo) -> Any:
        """Return the value at one temperature of a property that varies, where one is
        given or the model takes constants only.

        Raises
        ------
        ValueError : no temperature is given
        """
        key = str(info.field_name)
        T = info.data.get("material_temperature")
        if not isinstance(given, _VARYING) or (T is None and key in cls.varies):
            return given
        if T is None and key == "density":
            T = FILLED_AT
        if T is None:
            raise ValueError(
                "varies with temperature, and this model takes a constant; give "
                "material_temperature, at which it is taken, or a number"
            )
        return constant_at(key, given, T)

    @property
    def data_range(self) -> tuple[float, float]:
        """Temperatures [K] at which the data hold: those of the material, and tables."""
        low, high = 0.0, math.inf
        if self.material is not None and self.material_temperature is None:
            from contbed.scene.library import material

            low, high = material(self.material, "solid").T_range
        tables = range_of(*(getattr(self, key, None) for key in self.varies))
        return max(low, tables[0]), min(high, tables[1])


def _require_constants(known: dict[str, Any], values: dict[str, Any]) -> None:
    """Refuse properties of a material that vary with temperature and are not given
    as numbers.
    """
    for key, value in known.items():
        if isinstance(value, tuple) and key not in values:
            name = values["material"]
            raise ValueError(
                f"the {key} of {name} varies: give material_temperature, or {key} "
                "itself"
            )


def one_solid(solids: dict[str, Any]) -> dict[str, Any]:
    """Return the table of solids of a model that has one solid phase.

    Raises
    ------
    ValueError : it has none, or several
    """
    if len(solids) != 1:
        found = ", ".join(solids) or "none"
        raise ValueError(
            f"this model has one solid phase, [solids.NAME]; found {found}"
        )
    return solids


def the_only(solids: Mapping[str, Phase]) -> tuple[str, Phase]:
    """Return the only solid phase of a model with its name; see `one_solid`."""
    return next(iter(solids.items()))
