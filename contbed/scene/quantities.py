"""Types of the values in a scene: numbers with unit and bounds, converted to SI.

A plain number is SI; a string may carry a unit ("3 mm", "100 degC") and is converted
here.
"""

from __future__ import annotations

import ast
import inspect
import math
import sys
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetJsonSchemaHandler,
    JsonValue,
    Strict,
    Tag,
)
from pydantic_core import CoreSchema

CLOSURE = "closure"  # of a key in the schema: the kind of closures that it names
# beyond it, and below its inverse, fourth powers and squares of products leave a
# computer's numbers
LARGEST = 1e50


def computable(value: float) -> float:
    """Return a number whose powers a computer can hold.

    Raises
    ------
    ValueError : it is too large, or too close to zero
    """
    if value and math.isfinite(value) and not 1.0 / LARGEST <= abs(value) <= LARGEST:
        raise ValueError(
            f"{value:g} is no size that a bed has; numbers are 0, or from "
            f"{1 / LARGEST:g} to {LARGEST:g}"
        )
    return value


def in_unit(name: str) -> BeforeValidator:
    """Return a validator that turns "3 mm" into 0.003 for `name` "m", also inside
    lists; other values pass.
    """

    def convert(value: Any) -> Any:
        if isinstance(value, (list, tuple)):
            return tuple(convert(item) for item in value)
        if isinstance(value, str):
            from contbed.scene.units import to_si

            value = to_si(value, name)
        if isinstance(value, bool):
            raise ValueError(f"expected a number, found {str(value).lower()}")
        return computable(value) if isinstance(value, float) else value

    return BeforeValidator(convert)


class Table(BaseModel):
    """A TOML table: unknown keys are errors and values do not change after loading.

    The docstring below a key is its meaning in the schema.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Add the meanings of the keys to the schema of the table."""
        schema = handler(core_schema)
        keys = handler.resolve_ref_schema(schema)["properties"]
        for name, meaning in meanings(cls).items():
            key = keys[cls.model_fields[name].alias or name]
            key.setdefault("description", meaning)
        return schema


def meanings(table: type[Table]) -> dict[str, str]:
    """Return the meaning of each key of a table, the docstring below it.

    pydantic's `use_attribute_docstrings` would read the source of all tables at each
    start, which takes a tenth of the time to load a scene.
    """
    found = {}
    for base in reversed(table.__mro__):
        if not issubclass(base, Table):
            continue
        for key, below in pairwise(_source(base.__module__).get(base.__name__, [])):
            if isinstance(key, ast.AnnAssign) and isinstance(below, ast.Expr):
                text = ast.literal_eval(below.value)
                found[ast.unparse(key.target)] = " ".join(text.split())
    return found


@cache
def _source(module: str) -> dict[str, list[ast.stmt]]:
    """Return the statements of the classes of a module by their names."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {
        node.name: node.body for node in tree.body if isinstance(node, ast.ClassDef)
    }


def given_one(table: Table, *names: str) -> str:
    """Return the one of these keys of a table that is given.

    Raises
    ------
    ValueError : none is given, or several are
    """
    given = [name for name in names if getattr(table, name) is not None]
    if len(given) != 1:
        raise ValueError(
            f"give one of {', '.join(names)}; found {', '.join(given) or 'none'}"
        )
    return given[0]


class ClosureFile(Table):
    """A closure that was fitted from particles."""

    file: str
    """closure file, path relative to the scene"""


def form(value: Any) -> str:
    """Return how a value is written: "file", "parameters", "list", "name" or
    "number", the tags of unions.
    """
    if isinstance(value, ClosureFile) or (
        isinstance(value, dict) and "file" in value and "name" not in value
    ):
        return "file"
    if isinstance(value, (dict, Table)):
        return "parameters"
    if isinstance(value, (list, tuple)):
        return "list"
    if (
        isinstance(value, str)
        and not value.strip()[:1].isdigit()
        and value.strip()[:1] not in {"-", "+", "."}
    ):
        return "name"
    return "number"


def reject_bool(value: Any) -> Any:
    """Reject true and false, which Python would take for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError(f"expected an integer, found {str(value).lower()}")
    return value


def unit(name: str) -> tuple[Any, ...]:
    """Return the annotations of a finite number in the SI unit `name`."""
    return Field(allow_inf_nan=False, json_schema_extra={"unit": name}), in_unit(name)


def takes(kind: str) -> dict[str, JsonValue]:
    """Return what the schema says of a key that names closures of a kind:
    `json_schema_extra` of its field.
    """
    return {CLOSURE: kind}


Number = Annotated[float, *unit("1")]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Fraction = Annotated[Number, Field(gt=0, lt=1)]
Share = Annotated[Number, Field(ge=0, le=1)]
PositiveShare = Annotated[Number, Field(gt=0, le=1)]
ShareBelowOne = Annotated[Number, Field(ge=0, lt=1)]
Position = Annotated[float, *unit("m")]


def _listed(value: Any) -> Any:
    """Return a single coordinate as a list of one."""
    return (value,) if isinstance(value, (int, float, str)) else value


# coordinates, of which one may stand alone
Across = Annotated[
    tuple[Position, ...],
    BeforeValidator(_listed, json_schema_input_type=Position | tuple[Position, ...]),
]
Length = Annotated[Position, Field(gt=0)]
Permeability = Annotated[float, *unit("m**2"), Field(gt=0)]
Temperature = Annotated[float, *unit("K"), Field(gt=0)]
Conductivity = Annotated[float, *unit("W/m/K"), Field(ge=0)]
PositiveConductivity = Annotated[float, *unit("W/m/K"), Field(gt=0)]
Emissivity = PositiveShare
Extinction = Annotated[float, *unit("1/m"), Field(ge=0)]
Irradiance = Annotated[float, *unit("W/m**2"), Field(ge=0)]
WallCoefficient = Annotated[float, *unit("W/m**2/K"), Field(ge=0)]
HeatFlux = Annotated[float, *unit("W/m**2")]
HeatSource = Annotated[float, *unit("W/m**3")]
Density = Annotated[float, *unit("kg/m**3"), Field(gt=0)]
HeatCapacity = Annotated[float, *unit("J/kg/K"), Field(gt=0)]
Viscosity = Annotated[float, *unit("Pa*s"), Field(gt=0)]
Pressure = Annotated[float, *unit("Pa"), Field(gt=0)]
Seconds = Annotated[float, *unit("s"), Field(gt=0)]
Instant = Annotated[float, *unit("s"), Field(ge=0)]
FiniteFloat = Annotated[
    float, Strict(), Field(allow_inf_nan=False), AfterValidator(computable)
]
Velocity = Annotated[
    Annotated[FiniteFloat, Tag("number")]
    | Annotated[tuple[FiniteFloat, ...], Tag("list")],
    Field(json_schema_extra={"unit": "m/s"}),
    Discriminator(form),
    in_unit("m/s"),
]
Order = Annotated[Literal[1, 2, 3], BeforeValidator(reject_bool)]
Cells = Annotated[int, Strict(), Field(ge=1, le=10_000_000)]
Whole = Annotated[int, Strict()]
Natural = Annotated[Whole, Field(ge=0)]


def _composition_text(given: Any) -> Any:
    """Return a composition that a table gives, {"N2": 0.79, "O2": 0.21}, as its text."""
    if not isinstance(given, dict):
        return given
    return ", ".join(f"{species}:{amount}" for species, amount in given.items())


Composition = Annotated[
    str,
    BeforeValidator(_composition_text, json_schema_input_type=str | dict[str, float]),
]
Switch = Annotated[bool, Strict()]
