"""What all tables [solids.NAME] share: a material of the library, and the properties
of the particles' material.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import Discriminator, Field, Tag, model_validator

from contbed.scene.quantities import (
    Conductivity,
    Density,
    HeatCapacity,
    Length,
    Table,
    Temperature,
    form,
)
from contbed.scene.tables import Polynomial, from_library, names_material

HeatCapacityOfSolid = Annotated[
    Annotated[HeatCapacity, Tag("number")] | Polynomial, Discriminator(form)
]
ConductivityOfSolid = Annotated[
    Annotated[Conductivity, Tag("number")] | Polynomial, Discriminator(form)
]

_FROM_MATERIAL = (
    "density",
    "heat_capacity",
    "conductivity",
    "youngs_modulus",
    "poisson_ratio",
)

Phase = TypeVar("Phase")


class SolidPhase(Table):
    """Particles whose properties may come from a material of the library.

    A model adds its own keys, and declares a key again where it needs one or has
    another default for it. `varies` says whether properties may depend on temperature:
    as lists of coefficients a0 + a1 T + a2 T^2 + ...
    """

    varies: ClassVar[bool] = False

    material: str | None = Field(
        None,
        description="solid of the library; keys that are given replace its properties",
    )
    material_temperature: Temperature | None = Field(
        None,
        description="at which properties of the material that vary are taken as "
        "constants",
    )
    diameter: Length | None = Field(None, description="diameter of the particles")
    density: Density | None = Field(None, description="density of the solid material")

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
        ):
            raise ValueError("material_temperature has no use without material")
        if not names_material(values):
            return values
        properties = from_library("solid", values)
        known = {
            key: properties[key]
            for key in _FROM_MATERIAL
            if key in properties and key in cls.model_fields
        }
        if not cls.varies:
            _require_constants(known, values)
        return known | values


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
