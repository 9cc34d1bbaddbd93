"""What boundaries say of one phase: [boundary.NAME] gas.KEY and solids.NAME.KEY."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import Field, model_validator

from contbed.scene.quantities import Emissivity, Table, takes
from contbed.scene.series import HeatFluxOrSeries, TemperatureOrSeries
from contbed.scene.tables import WallCoefficientOrClosure
from contbed.scene.toml_lines import KeyPath

TEMPERATURES = ("temperature", "fixed_temperature")
FLUXES = ("heat_flux", "coefficient", "emissivity")


class ThermalCondition(Table):
    """Thermal condition of one phase on one boundary: a temperature, or fluxes, which
    add up; none is adiabatic.
    """

    temperature: TemperatureOrSeries | None = None
    """Danckwerts: of the stream while it enters; nothing while it leaves"""
    fixed_temperature: TemperatureOrSeries | None = None
    """Dirichlet: prescribed temperature"""
    heat_flux: HeatFluxOrSeries | None = None
    """into the bed"""
    coefficient: WallCoefficientOrClosure | None = Field(
        None, json_schema_extra=takes("wall")
    )
    """Robin: wall coefficient to `ambient`"""
    emissivity: Emissivity | None = None
    """of a surface that radiates to surroundings at `ambient`"""
    ambient: TemperatureOrSeries | None = None
    """temperature of the surroundings"""

    @model_validator(mode="after")
    def _temperature_or_fluxes(self) -> ThermalCondition:
        given = [
            key for key in (*TEMPERATURES, *FLUXES) if getattr(self, key) is not None
        ]
        if len(given) > 1 and not set(given) <= set(FLUXES):
            raise ValueError(
                f"{', '.join(given)}: give a temperature alone, or any of "
                f"{', '.join(FLUXES)}, which add up"
            )
        if self.meets_surroundings and self.ambient is None:
            raise ValueError(
                "ambient, the temperature of the surroundings, is missing beside "
                "coefficient or emissivity"
            )
        if self.ambient is not None and not self.meets_surroundings:
            raise ValueError(
                "ambient alone passes no heat; give coefficient or emissivity as well"
            )
        return self

    @property
    def meets_surroundings(self) -> bool:
        """Whether heat depends on the temperature of the surroundings."""
        return self.coefficient is not None or self.emissivity is not None

    @property
    def exchanges_heat(self) -> bool:
        """Whether a temperature or a flux is given."""
        keys = (*TEMPERATURES, *FLUXES)
        return any(getattr(self, key) is not None for key in keys)


class WallHeat(Table):
    """Heat through a wall into the bed."""

    coefficient: WallCoefficientOrClosure | None = Field(
        None, json_schema_extra=takes("wall")
    )
    """of the wall on its inner area, to `ambient`; beside species by name with
    packed_bed.section"""
    ambient: TemperatureOrSeries | None = None
    """temperature of the surroundings of the wall"""
    heat_flux: HeatFluxOrSeries | None = None
    """of the wall into the bed, on its inner area"""

    @model_validator(mode="after")
    def _one_way(self) -> WallHeat:
        if self.coefficient is not None and self.heat_flux is not None:
            raise ValueError("give coefficient and ambient, or heat_flux")
        if (self.coefficient is None) != (self.ambient is None):
            raise ValueError("coefficient and ambient belong together")
        return self

    @property
    def passes_heat(self) -> bool:
        """Whether the wall has a coefficient or a flux."""
        return self.coefficient is not None or self.heat_flux is not None


def conditions_of(boundary: Mapping[str, Any]) -> Iterator[tuple[KeyPath, str, Any]]:
    """Yield the path, the phase and the table of each condition of a phase; the
    phase is "gas" or a solid's name.
    """
    for side, table in boundary.items():
        gas = table.condition("fluid")
        if gas is not None:
            yield ("boundary", side, *table.key("fluid")), "gas", gas
        for name, condition in table.solids.items():
            yield ("boundary", side, "solids", name), name, condition
