"""The vocabulary of a scene: every table and key, with unit, bounds and meaning, as frozen pydantic models in SI.

A plain number is SI; a string may carry a unit ("3 mm", "100 degC") and is converted here, at the door, so that
nothing behind it ever sees a unit. A table that is absent means that its physics is absent. Defaults live here only.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from contbed.radiation.scene import Radiation, RadiationCondition, Tubes
from contbed.scene.mesh import Mesh, MeshFile
from contbed.scene.quantities import (
    Conductivity,
    Emissivity,
    Fraction,
    HeatSource,
    Instant,
    NonNegative,
    Seconds,
    Table,
    Whole,
    form,
    given_one,
    takes,
)
from contbed.scene.series import (
    HeatFluxOrSeries,
    TemperatureOrProfile,
    TemperatureOrSeries,
    VelocityOrSeries,
)
from contbed.scene.tables import (
    ConductivityOrClosure,
    CycleSettings,
    Fluid,
    Named,
    NonNegativeOrClosure,
    NumberOrClosure,
    Output,
    Packing,
    PermeabilityOrClosure,
    SceneBase,
    Solid,
    Solver,
    WallCoefficientOrClosure,
)


def dispersion_form(value: Any) -> str:
    """Return the `form` of a value; a table without a name holds the two conductivities themselves."""
    nameless = isinstance(value, Dispersion) or (isinstance(value, dict) and "name" not in value)
    return "table" if nameless else form(value)


class Bed(Packing):
    """The packing and its resistance to flow."""

    permeability: PermeabilityOrClosure = Field("permeability_ergun", description="permeability of the bed")
    forchheimer: NonNegativeOrClosure = Field("forchheimer_ergun", description="inertial drag coefficient c_F")


class Flow(Table):
    """Superficial velocities; a number is along the bed axis (x, or z when axisymmetric), a list is a vector."""

    velocity: VelocityOrSeries = Field(description="fluid, mean over the inlet")
    velocity_solid: VelocityOrSeries = Field(0.0, description="superficial velocity of the solid; 0 for a bed at rest")


class Dispersion(Table):
    """Constant dispersion conductivities, along and across the flow."""

    axial: Conductivity = Field(description="thermal dispersion along the flow")
    transverse: Conductivity = Field(0.0, description="thermal dispersion across the flow")


DispersionOrClosure = Annotated[Annotated[Dispersion, Tag("table")] | Named, Discriminator(dispersion_form)]


class Heat(Table):
    """Two energy equations, one for each phase."""

    nusselt: NonNegativeOrClosure = Field(description="Nusselt number of the exchange between fluid and particles")
    reynolds: NonNegative | None = Field(
        None, description="fixed Reynolds number for the closures instead of the one from velocities and properties"
    )
    conductivity_fluid: ConductivityOrClosure = Field(
        "conductivity_phase",
        description="effective, without dispersion; conductivity_phase is eps k_fluid; 0 where that of the solid is a "
        "closure of the whole bed",
        json_schema_extra=takes("conductivity"),
    )
    conductivity_solid: ConductivityOrClosure = Field(
        "conductivity_phase",
        description="effective; conductivity_phase is (1-eps) k_solid",
        json_schema_extra=takes("conductivity"),
    )
    tortuosity: NumberOrClosure | None = Field(
        None, description="tortuosity parameter G of the cross conduction between the phases; absent means none"
    )
    dispersion: DispersionOrClosure | None = Field(
        None,
        description="thermal dispersion of the fluid: a closure, or axial and transverse values; absent: none",
    )


class Particle(Table):
    """Intraparticle conduction; absent: lumped particles, external film only."""

    heat: Literal["auto", "lumped", "effective", "interior"] = Field(
        "auto",
        description="one temperature per particle; one with the corrected film coefficient; temperatures inside; "
        "auto: the cheapest within solver.accuracy",
    )
    points: Annotated[Whole, Field(ge=2, le=20)] | None = Field(
        None,
        description="temperatures inside, beside the surface; absent: 3, with auto the fewest within solver.accuracy",
    )


class PhaseCondition(Table):
    """Thermal condition of one phase on one boundary: exactly one of the five."""

    fixed: TemperatureOrSeries | None = Field(None, description="prescribed temperature")
    inflow: TemperatureOrSeries | None = Field(
        None, description="Danckwerts: temperature of the stream while it enters; nothing while it leaves"
    )
    flux: HeatFluxOrSeries | None = Field(None, description="heat into the bed")
    coefficient: WallCoefficientOrClosure | None = Field(
        None, description="Robin: wall coefficient to `ambient`", json_schema_extra=takes("wall")
    )
    emissivity: Emissivity | None = Field(None, description="of a surface that radiates to surroundings at `ambient`")
    ambient: TemperatureOrSeries | None = Field(None, description="temperature of the surroundings")

    @model_validator(mode="after")
    def _exactly_one(self) -> PhaseCondition:
        given = given_one(self, "fixed", "inflow", "flux", "coefficient", "emissivity")
        if (given in ("coefficient", "emissivity")) != (self.ambient is not None):
            name = given if self.ambient is None else "coefficient or emissivity"
            raise ValueError(f"{name} and ambient belong together")
        return self

    @property
    def ties(self) -> bool:
        """Whether a steady temperature is determined by this condition; a flux alone leaves it open."""
        return self.flux is None

    @property
    def linear(self) -> bool:
        """Whether the heat that crosses the boundary is linear in the temperature, closures left aside."""
        return self.emissivity is None


class Boundary(Table):
    """Conditions on one named boundary; what is absent is adiabatic, and a frictionless wall for the flow."""

    type: Literal["inlet", "outlet", "no_slip", "slip"] | None = Field(
        None, description="absent: inlet or outlet by the sign of the velocity, slip on walls"
    )
    fluid: PhaseCondition | None = Field(None, description="thermal condition of the fluid")
    solid: PhaseCondition | None = Field(None, description="thermal condition of the solid")
    radiation: RadiationCondition | None = Field(None, description="absent: a mirror")


class Region(Table):
    """Heat sources in one named region of the mesh, per bed volume, and tubes."""

    source_fluid: HeatSource = Field(0.0, description="heat source in the fluid, per bed volume")
    source_solid: HeatSource = Field(0.0, description="heat source in the solid, per bed volume")
    tubes: Tubes | None = Field(None, description="absorb and emit radiation; with [heat] and [radiation]")


class Time(Table):
    """A transient run; absent means steady."""

    end: Seconds = Field(description="time at which the run ends")
    initial_fluid: TemperatureOrProfile = Field(
        description="initial temperature of the fluid: a number, or a profile from a file"
    )
    initial_solid: TemperatureOrProfile = Field(
        description="initial temperature of the solid: a number, or a profile from a file"
    )
    times: tuple[Instant, ...] = Field((), description="output times; the end is always one")
    step: Seconds | None = Field(None, description="fixed step; error-controlled if absent")
    tolerance: Fraction = Field(1e-4, description="local error over the span of temperatures")
    cycle: CycleSettings | None = Field(
        None, description="the run is one period of a cyclic steady state; initial temperatures are a guess"
    )
    checkpoint_every: Seconds = Field(10.0, description="wall-clock time between checkpoints")


def _absent() -> Any:
    return None


class Scene(SceneBase):
    """One run of a packed or moving bed."""

    kind: ClassVar[str] = "packed_bed"
    renamed: ClassVar[Mapping[str, str]] = {"boundary.NAME.flow": "type"}

    mesh: Mesh
    # fluid, bed and flow are None only in a medium that merely radiates; `checks` sees to it
    fluid: Fluid = Field(default_factory=_absent)
    solid: Solid | None = None
    bed: Bed = Field(default_factory=_absent)
    flow: Flow = Field(default_factory=_absent)
    heat: Heat | None = None
    particle: Particle | None = None
    radiation: Radiation | None = None
    boundary: dict[str, Boundary] = Field(
        default_factory=dict,
        description="conditions by name of the boundary; an absent boundary is adiabatic and without friction",
    )
    region: dict[str, Region] = Field(
        default_factory=dict, description="heat sources and tubes by name of the region of the mesh"
    )
    time: Time | None = None
    solver: Solver = Solver()
    output: Output = Output()

    @property
    def mesh_path(self) -> Path | None:
        """The mesh file of this scene, found from any working directory; None for a built-in mesh."""
        return self._origin.base / self.mesh.file if isinstance(self.mesh, MeshFile) else None
