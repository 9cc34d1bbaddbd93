"""What boundaries say of one phase: [boundary.NAME] gas.KEY and solids.NAME.KEY."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import Field, model_validator

from contbed.scene.quantities import Emissivity, Table, takes
from contbed.scene.series import HeatFluxOrSeries, TemperatureOrSeries
from contbed.scene.tables import WallCoefficientOrClosure
from contbed.scene.toml_lines import KeyPath

THERMAL = ("temperature", "fixed_temperature", "heat_flux", "coefficient", "emissivity")


class ThermalCondition(Table):
    """Thermal condition of one phase on one boundary: at most one of the five; none
    is adiabatic.
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
    def _at_most_one(self) -> ThermalCondition:
        given = [name for name in THERMAL if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(
                f"give one of {', '.join(THERMAL)}; found {', '.join(given)}"
            )
        needs_ambient = given in (["coefficient"], ["emissivity"])
        if needs_ambient != (self.ambient is not None):
            name = given[0] if needs_ambient else "coefficient or emissivity"
            raise ValueError(f"{name} and ambient belong together")
        return self

    @property
    def exchanges_heat(self) -> bool:
        """Whether one of the five is given."""
        return any(getattr(self, name) is not None for name in THERMAL)


class WallHeat(Table):
    """Heat through a wall into the gas, or into the bed of one temperature."""

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
