"""Tables that scenes of several physics share: closures by name, numerics, output.

Absent keys take the default that stands here, once. Values are in SI behind
`quantities`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import ConfigDict, Discriminator, Field, PrivateAttr, Tag

from contbed.errors import SceneError
from contbed.scene import schema
from contbed.scene.quantities import (
    Across,
    ClosureFile,
    Conductivity,
    FiniteFloat,
    Fraction,
    Instant,
    NonNegative,
    Number,
    Order,
    Permeability,
    Position,
    Positive,
    Seconds,
    Switch,
    Table,
    WallCoefficient,
    Whole,
    form,
)
from contbed.scene.toml_lines import KeyPath, Origin


def from_library(phase: str, values: Any) -> Any:
    """Return the data of the library for a table's `material`, at its
    `material_temperature` if given.

    Raises
    ------
    ValueError : no such material, or the temperature is out of its range
    """
    from contbed.scene.library import material

    try:
        found = material(values["material"], phase)
    except SceneError as error:
        raise ValueError(str(error)) from None
    properties: dict[str, Any] = dict(found.properties())
    if (given := values.get("material_temperature")) is not None:
        from contbed.scene.units import to_si

        low, high = found.T_range
        T = to_si(given, "K") if isinstance(given, str) else given
        if (
            isinstance(T, bool)
            or not isinstance(T, int | float)
            or not low <= T <= high
        ):
            raise ValueError(
                f"material_temperature = {given!r}: {found.name} is known from {low:g} "
                f"to {high:g} K"
            )
        properties = dict(found.at(float(T)))
    return {
        key: a[0] if isinstance(a, tuple) and len(a) == 1 else a
        for key, a in properties.items()
    }


def names_material(values: Any) -> bool:
    """Return whether a table takes properties of a material of the library."""
    return isinstance(values, dict) and isinstance(values.get("material"), str)


Polynomial = Annotated[
    tuple[FiniteFloat, ...],
    Tag("list"),
    Field(min_length=1, max_length=12, json_schema_extra={schema.POWERS_OF: "K"}),
]


class Closure(Table):
    """A closure by name; further keys are the closure's own parameters."""

    model_config = ConfigDict(extra="allow", frozen=True)
    name: str
    """name of the closure, with or without its kind"""


Named = Annotated[str, Tag("name")] | Annotated[Closure, Tag("parameters")]
NamedOrFile = Named | Annotated[ClosureFile, Tag("file")]
Quantity = TypeVar("Quantity")
# a number of a quantity, or a closure that gives it
OrClosure = Annotated[
    Annotated[Quantity, Tag("number")] | NamedOrFile, Discriminator(form)
]
PermeabilityOrClosure = OrClosure[Permeability]
NonNegativeOrClosure = OrClosure[NonNegative]
ConductivityOrClosure = OrClosure[Conductivity]
NumberOrClosure = OrClosure[Number]
WallCoefficientOrClosure = OrClosure[WallCoefficient]


class BalancedRun(Table):
    """What a run must keep to be accepted."""

    balance_tolerance: Positive = 1e-10
    """largest relative residual of a balance that a run accepts"""
    strict: Switch = False
    """a closure out of its range is an error"""


class NewtonSolver(BalancedRun):
    """Newton's method, and what a run must keep."""

    newton_tolerance: Annotated[Fraction, Field(le=1e-3)] = 1e-10
    """residual norm, relative to the scale of the equations, at which Newton's method
    has converged"""
    newton_iterations: Whole = Field(30, ge=1, le=1000)
    """most iterations of Newton's method"""


class FieldSolver(NewtonSolver):
    """Numerics; the defaults suit nearly all scenes."""

    degree: Order = 2
    """polynomial degree of the temperatures"""
    tolerance: Fraction = 1e-5
    """target error of theta for automatic meshes"""
    memory_GB: Positive | None = None
    """refuse a factorisation predicted above this; 60 % of the free memory if absent"""


class CycleSettings(Table):
    """A run that is one period of a cycle: it begins with the state that it ends
    with.
    """

    tolerance: Fraction = 1e-8
    """change over one period over the span of temperatures, in reacting beds also of
    amounts over those that enter"""


class RunInTime(Table):
    """A transient run of a packed bed."""

    end: Seconds
    """time at which the run ends"""
    times: tuple[Instant, ...] = ()
    """output times; the end is always one"""
    cycle: CycleSettings | None = None
    """the run is one period of a cyclic steady state; the state at the start is a guess
    """
    checkpoint_every: Seconds = 10.0
    """wall-clock time between checkpoints"""


class Output(Table):
    """What a run writes besides summary.json."""

    positions: tuple[Position, ...] = ()
    """profile positions along the axis; automatic if empty"""
    profiles: Switch = True
    """profiles.csv, which sweeps of many scenes may not need"""
    fields: Switch = True
    """write fields for ParaView (.vtu)"""
    plots: Switch = True
    """draw plots (.png)"""


class FieldOutput(Output):
    """What a run on a mesh of any dimension writes besides summary.json."""

    across: Across | None = None
    """other coordinate of the line of profiles, or a list of both; absent: the middle,
    or a line inside of the mesh"""


class SceneBase(Table):
    """What scenes of all kinds have in common."""

    kind: ClassVar[str]
    # tables of other kinds that this one does not take: why, and what to do
    refused: ClassVar[Mapping[str, str]] = {}

    title: str = ""
    """title of the scene, shown in plots, reports and summary.json"""
    model: str | None = None
    """name of the model; absent: derived from the tables"""

    _origin: Origin = PrivateAttr(default_factory=Origin)
    _warnings: tuple[str, ...] = PrivateAttr(())
    _ignored: tuple[KeyPath, ...] = PrivateAttr(())
    # key and name of files whose columns stand in the scene
    _tables: tuple[tuple[KeyPath, str], ...] = PrivateAttr(())

    @property
    def origin(self) -> Origin:
        """Where the values come from: a name for messages, the lines of the keys,
        the folder of the file.
        """
        return self._origin

    def remark(self, path: KeyPath, text: str) -> None:
        """Add a warning that is known only once a file of the scene has been read."""
        line = f"{self.origin.place(path)}: {text}"
        if line not in self._warnings:
            self._warnings = (*self._warnings, line)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the scene says that is possible but seldom meant, each with file,
        line and key.
        """
        return self._warnings

    @property
    def ignored(self) -> tuple[KeyPath, ...]:
        """Keys of the file that only other models have; see `scene.other_models`."""
        return self._ignored
