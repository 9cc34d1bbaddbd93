"""Tables [boundary.NAME] of a reacting bed: streams that enter at its ends, and heat
through its wall.
"""

from __future__ import annotations

from pydantic import Field, model_validator

from contbed.reacting_bed.inlet_series import (
    CompositionOrSeries,
    MassFluxOrSeries,
    MolarFluxOrSeries,
    SpeedOrSeries,
)
from contbed.scene.boundary import WallHeat
from contbed.scene.quantities import Table
from contbed.scene.series import TemperatureOrSeries

FLOWS = ("velocity", "mass_flux", "molar_flux")  # ways to give the flow of the gas


class GasCondition(Table):
    """The gas that enters at one end; one boundary gives its flow, in one of three
    ways, positive into the bed.
    """

    velocity: SpeedOrSeries | None = None
    """superficial, at its temperature"""
    mass_flux: MassFluxOrSeries | None = None
    """per area of the bed"""
    molar_flux: MolarFluxOrSeries | None = None
    """per area of the bed"""
    temperature: TemperatureOrSeries | None = None
    """Danckwerts: what enters is known, not the state inside"""
    fixed_temperature: TemperatureOrSeries | None = None
    """state inside of the inlet, composition included"""
    composition: CompositionOrSeries | None = None
    """mole fractions of what enters here; absent: gas.composition"""

    @model_validator(mode="after")
    def _one(self) -> GasCondition:
        for keys in (FLOWS, ("temperature", "fixed_temperature")):
            if sum(getattr(self, key) is not None for key in keys) > 1:
                raise ValueError(f"give one of {', '.join(keys)}")
        return self


class SolidCondition(Table):
    """A solid phase that enters at one end."""

    velocity: SpeedOrSeries | None = None
    """superficial, volume of particles per area and time as if the phase filled the
    bed, positive into the bed; absent at both ends: at rest"""
    temperature: TemperatureOrSeries | None = None
    """of the particles that enter; needed with [heat]"""


class Boundary(WallHeat):
    """What enters at `left` or `right`; heat through the `wall`, into the gas (two
    temperatures) or the bed (one).
    """

    gas: GasCondition | None = None
    """the gas that enters here"""
    solids: dict[str, SolidCondition] = Field(default_factory=dict)
    """by name"""
