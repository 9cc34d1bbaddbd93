"""Tables of a scene of a bubbling bed: a fluidized bed along its height, in SI.

    [bubbling_bed]            height, section and packing of the emulsion
    [bubbling_bed.bubbles]    absent: all gas flows through the emulsion
    [bubbling_bed.tubes], [bubbling_bed.walls]               immersed surfaces
    [bubbling_bed.distributor], [bubbling_bed.freeboard]     what bounds the bed
    [bubbling_bed.drain]      what leaves with the bed material
    [gas]                     properties of the gas, by its composition
    [boundary.bottom]         what enters below the distributor
    [solids.NAME]             one solid phase, with its feed, heat release, exchange
                              with other phases, and what it is made of
    [reactions.NAME]          see `chemistry.scene`
    [closures]                closures that other models have as well
    [radiation]               level by name; absent: none
    [continuation]            steady states over one value of the scene

Physics whose table is absent is left out. There are two ways to write a scene. With
boundary.bottom.gas.capacity_flow every coefficient is a number, frozen, and flows of
streams are capacity flows, mass flow times heat capacity. With
boundary.bottom.gas.mass_flow and [gas] a coefficient may be a closure by name, a file,
or a number, and flows are mass flows.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Discriminator, Field, model_validator

from contbed.bubbling_bed.chemistry.scene import Reactions
from contbed.bubbling_bed.solids import Solid
from contbed.bubbling_bed.tables import (
    BubblingBed,
    CapacityFlow,
    MassFlow,
    Speed,
    SpeedOrClosure,
)
from contbed.scene import continuation
from contbed.scene.gas import GasCantera, GasOfComposition
from contbed.scene.quantities import (
    Cells,
    Fraction,
    Number,
    Order,
    Positive,
    Switch,
    Table,
    Temperature,
    Whole,
    form,
    given_one,
)
from contbed.scene.tables import NamedOrFile, NewtonSolver, Output, SceneBase

NamedClosure = Annotated[NamedOrFile, Discriminator(form)]


class EnteringGas(Table):
    """What enters below the distributor, all at one temperature."""

    capacity_flow: CapacityFlow | None = None
    """of the emulsion's gas; coefficients are numbers"""
    mass_flow: MassFlow | None = None
    """of all gas, with [gas]; coefficients may be closures"""
    velocity: Speed | None = None
    """superficial, in place of mass_flow"""
    temperature: Temperature
    """of the gas that enters"""

    @model_validator(mode="after")
    def _one(self) -> EnteringGas:
        given_one(self, "capacity_flow", "mass_flow", "velocity")
        return self

    @property
    def computed(self) -> bool:
        """Whether coefficients follow from the properties of gas and particles."""
        return self.capacity_flow is None


class Bottom(Table):
    """The distributor as a boundary."""

    gas: EnteringGas


class Boundary(Table):
    """Boundaries of the bed."""

    bottom: Bottom


class Closures(Table):
    """Closures by name, which other models have under the same keys."""

    minimum_fluidization: SpeedOrClosure = "minimum_fluidization_grace"
    """superficial velocity"""
    expansion: NamedClosure | None = None
    """height over settled_height; absent: by the volume of the bubbles"""
    nusselt: NamedClosure | None = None
    """particles to the gas of the emulsion, of all solid phases that give none"""


class Initial(Table):
    """Where Newton's method starts."""

    temperature: Annotated[Temperature, Field(ge=200)] = 1100.0
    """of everything"""


class Radiation(Table):
    """Radiation between the particles of a bubbling bed."""

    level: Literal["none", "pairwise", "paper", "two_flux", "p1"] = "p1"
    """pairwise, paper: among the solid phases at one height only, eqs. 2-11 and 34 of
    Rabi & de Souza-Santos"""
    correction: Literal["close_packed", "independent"] | None = None
    """extinction over the voidage, the default, or the limit of points far apart;
    pairwise, paper: that"""
    anisotropy: Annotated[Number, Field(ge=-1, le=1)] = 0.0
    """mean cosine of scattering"""


class Continuation(continuation.Continuation):
    """The branch of steady states from the value in this scene to another.

    It passes the folds between them.
    """

    points: Annotated[Whole, Field(ge=3, le=10_000)] = 200
    """at most"""
    first_fold: Switch = False
    """end at the first fold, where only its distance is wanted"""


def _along_the_height(cells: Any) -> Any:
    """Return the last of the numbers of cells of a rectangle or box."""
    return cells[-1] if isinstance(cells, list) and cells else cells


class Mesh(Table):
    """Cells along the height, graded to the layers at both ends."""

    cells: Annotated[Cells | None, BeforeValidator(_along_the_height)] = None
    """of a list the last; absent: by solver.tolerance"""
    refine: Whole = Field(0, ge=0, le=12)
    """uniform refinements after construction"""


class Solver(NewtonSolver):
    """Numerics; the defaults suit nearly all scenes."""

    degree: Order = 3
    """polynomial degree of all fields"""
    tolerance: Fraction = 1e-6
    """target error of automatic meshes, relative to the temperatures"""
    newton_iterations: Whole = Field(60, ge=1, le=1000)
    """most iterations of Newton's method"""
    memory_GB: Positive | None = None
    """refuse a factorisation predicted above this"""


class BubblingScene(SceneBase):
    """One run of a bubbling bed."""

    kind: ClassVar[str] = "bubbling_bed"
    time: ClassVar[None] = None

    bubbling_bed: BubblingBed
    gas: GasOfComposition | None = None
    """absent: coefficients are numbers"""
    boundary: Boundary
    solids: dict[str, Solid]
    """solid phases by name"""
    reactions: Reactions | None = None
    """absent: an inert gas"""
    closures: Closures = Closures()
    initial: Initial = Initial()
    radiation: Radiation = Radiation(level="none")
    continuation: Continuation | None = None
    mesh: Mesh = Mesh()
    solver: Solver = Solver()
    output: Output = Output()

    @property
    def inlet(self) -> EnteringGas:
        """What enters below the distributor."""
        return self.boundary.bottom.gas

    @property
    def mixture(self) -> GasCantera:
        """The [gas] of a scene whose coefficients follow from it."""
        assert self.gas is not None
        return self.gas

    @property
    def computed(self) -> bool:
        """Whether coefficients follow from the properties of gas and particles."""
        return self.inlet.computed

    @property
    def gas_flow(self) -> float:
        """Mass flow of all gas that enters [kg/s]; 0 where coefficients are frozen."""
        inlet = self.inlet
        if inlet.velocity is None:
            # a recorded form asks for no value
            return 0.0 if inlet.mass_flow is None else inlet.mass_flow
        from contbed.materials.constants import constants_of

        gas = constants_of(self.mixture, inlet.temperature, self.origin.base)
        return inlet.velocity * gas.density * self.bubbling_bed.section

    @property
    def present(self) -> dict[str, Solid]:
        """The solid phases with a volume share above zero."""
        return {
            name: item for name, item in self.solids.items() if item.volume_share > 0
        }

    @property
    def surface_of_particles(self) -> dict[str, float]:
        """Surface of each solid phase that is present, over the volume of the
        emulsion [1/m].
        """
        solids = self.bubbling_bed.solids_fraction
        return {
            name: 6.0 * solids * item.volume_share / (item.sphericity * item.diameter)
            for name, item in self.present.items()
        }

    @property
    def fuel(self) -> str | None:
        """Name of the solid phase that is the fuel; None without one."""
        return next((name for name, item in self.solids.items() if item.fuel), None)

    @property
    def limestone(self) -> str | None:
        """Name of the solid phase that is the limestone; None without one."""
        return next(
            (name for name, item in self.solids.items() if item.limestone), None
        )
