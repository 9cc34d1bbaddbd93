"""Shapes of JSON files that contbed writes, which are looked at when they are read:
others may have changed them.

A shape is a pydantic model of what is used of a file; what else stands there is left
alone. A file that is cut, empty, of another program or version is reported in one
sentence with the place that differs.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from contbed.errors import ContbedError

Number = float | None  # None stands for nan, which JSON lacks
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
SHOWN = 40  # characters of a value in a message
_EXPECTED = {
    "dict_type": "a table",
    "model_type": "a table",
    "list_type": "a list",
    "string_type": "a text",
    "float_type": "a number",
    "int_type": "an integer",
    "bool_type": "true or false",
    "too_short": "more items",
    "too_long": "fewer items",
}


class Shape(BaseModel):
    """A table with the keys that are used; those without a default are required."""

    model_config = ConfigDict(strict=True, extra="ignore")


class Use(Shape):
    """How an argument of a closure was used."""

    used: Pair
    declared: Pair
    share_outside: Number


class Closure(Shape):
    """A closure of a run."""

    name: str
    share_outside: Number = None
    ranges: dict[str, Use] = {}


class BalanceParts(Shape):
    """A balance of a run."""

    unit: str | None = None
    relative_residual: Number = None


class Item(Shape):
    """What was built or left out."""

    what: str
    why: str


class RunSummary(Shape):
    """summary.json of a run; that of a failed run may be incomplete."""

    status: str
    versions: dict[str, Any] = {}
    scene: dict[str, Any] = {}
    dofs: dict[str, Any] | None = None
    timings: dict[str, float] = {}
    balances: dict[str, BalanceParts] = {}
    closures: list[Closure] = []
    built: list[Item] = []
    skipped: list[Item] = []
    warnings: list[str] = []
    qoi: dict[str, Any] = {}
    units: dict[str, str] = {}
    files: list[str] = []


def read_json(path: Path, shape: type[Shape], what: str, remedy: str) -> dict[str, Any]:
    """Return the content of a file that has a shape.

    Parameters
    ----------
    path : of the file; shape : of its content
    what : names the content, "the summary of a run"; remedy : what the user does if it
        is not, "run the scene again"

    Raises
    ------
    ContbedError : the file cannot be read, is no JSON or has another shape
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        shape.model_validate(content)
    except OSError as error:
        raise ContbedError(
            f"{path}: cannot be read: {error.strerror}; {remedy}"
        ) from error
    except ValidationError as error:
        raise ContbedError(
            f"{path}: not {what}: {_difference(error)}; {remedy}"
        ) from error
    except (ValueError, RecursionError) as error:
        why = (
            "it is empty"
            if path.stat().st_size == 0
            else f"it is damaged ({' '.join(str(error).split())})"
        )
        raise ContbedError(f"{path}: not {what}: {why}; {remedy}") from error
    found: dict[str, Any] = content
    return found


@contextmanager
def fitting(path: Path, what: str, remedy: str) -> Iterator[None]:
    """Report names, lengths and types in a file that its shape says nothing of.

    Raises
    ------
    ContbedError : in place of an error of the block that such differences cause
    """
    try:
        yield
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        raise ContbedError(
            f"{path}: not {what}: its parts do not fit together ({error}); {remedy}"
        ) from error


def _difference(error: ValidationError) -> str:
    """Return the first place that differs, with what was expected there."""
    first: Mapping[str, Any] = error.errors()[0]
    place = "".join(
        f"[{key}]" if isinstance(key, int) else f".{key}" for key in first["loc"]
    ).removeprefix(".")
    if first["type"] == "missing":
        return f"{place} is missing"
    expected = _EXPECTED.get(first["type"])
    shown = json.dumps(first["input"], default=str, ensure_ascii=False)
    shown = shown if len(shown) <= SHOWN else f"{shown[: SHOWN - 4]} ..."
    told = f"expected {expected}, found {shown}" if expected else first["msg"]
    return f"{place}: {told}" if place else told
