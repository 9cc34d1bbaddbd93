"""Closure file -> closure: reads and checks what `contbed.closures.transferred`
describes; errors with file:line.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from contbed.closures.transferred import ARGUMENTS, FORMAT, Transferred
from contbed.errors import SceneError
from contbed.scene.quantities import LARGEST, FiniteFloat, Natural, Switch, Table
from contbed.scene.refusals import table_of
from contbed.scene.stamp import Stamp, stamp_of
from contbed.scene.toml_lines import KeyPath, read


def _rising(ends: tuple[float, float]) -> tuple[float, float]:
    if ends[0] > ends[1]:
        raise ValueError("is not [lowest, highest]")
    return ends


Interval = Annotated[tuple[FiniteFloat, FiniteFloat], AfterValidator(_rising)]


class Scale(Table):
    """How a variable enters the terms."""

    scale: Literal["log", "linear"]
    """its logarithm or itself"""
    reference: FiniteFloat
    """value at which it counts as zero"""

    @model_validator(mode="after")
    def _has_a_logarithm(self) -> Self:
        if self.scale == "log" and self.reference <= 0.0:
            raise ValueError("has a logarithm of a reference that is not above 0")
        return self


class Fitted(Table):
    """A fitted number."""

    value: FiniteFloat
    """most probable value"""
    interval: Interval | None = None
    """that holds it at 95 %"""
    given: Switch = False
    """whether it was not fitted"""


class Term(Fitted):
    """A term of a polynomial."""

    powers: tuple[Natural, ...]
    """of each variable"""


class Power(Table):
    """The numbers of a power law, base + a Re^b Pr^c."""

    base: Fitted
    """value without flow"""
    a: Fitted
    """factor"""
    b: Fitted
    """exponent of Re"""
    c: Fitted
    """exponent of Pr"""


class Content(Table):
    """A closure file."""

    kind: ClassVar[str] = "closure"

    format: int
    """of this file"""
    closure: Literal["conductivity", "nusselt", "bed_tube"] = Field(alias="kind")
    """what the closure returns"""
    form: Literal["log_polynomial", "power"]
    """how it depends on its arguments"""
    variables: dict[str, Scale] = Field(default_factory=dict)
    """arguments of a polynomial, or ratios of two, in the order of the powers"""
    terms: tuple[Term, ...] = ()
    """of a polynomial"""
    parameters: Power | None = None
    """of a power law"""
    range: dict[str, Interval]
    """of arguments, or ratios of two"""
    residuals: dict[str, Any] = Field(default_factory=dict)
    """of the fit, for people"""
    provenance: dict[str, Any] = Field(min_length=1)
    """where the closure comes from, such as scene = ..."""

    @property
    def names(self) -> tuple[str, ...]:
        """What the closure depends on."""
        return ("Re", "Pr") if self.form == "power" else tuple(self.variables)


def closure_of(file: str, base: Path, kind: str) -> Transferred:
    """Return the closure in a file in the folder `base`; SceneError with the file's
    line if it cannot be used.
    """
    path = base / file
    try:
        stamp = stamp_of(path)
    except (OSError, ValueError):
        raise SceneError(
            f"no closure file {file!r}; looked for {path.absolute()}"
        ) from None
    found = _cached(str(path), file, stamp)
    if found.sheet.kind != kind:
        raise SceneError(
            f"{file} holds a closure of kind {found.sheet.kind!r}, wanted kind {kind!r}"
        )
    return found


@lru_cache(maxsize=64)
def _cached(path: str, name: str, stamp: Stamp) -> Transferred:
    content, origin = read(path)
    if type(version := content.get("format")) is not int or version != FORMAT:
        found = (
            "missing: this is no closure file of contbed"
            if version is None
            else f"is {version!r}; this version of contbed reads {FORMAT}: extract it "
            "anew"
        )
        raise SceneError(f"{origin.place(('format',))}: {found}")
    table = table_of(Content, content, origin)
    closure = Transferred(name, content)
    problems = list(_contradictions(table)) or list(_beyond(table, closure))
    given = table.provenance.get("hash")
    if not problems and given not in (None, content_hash(content)):
        text = (
            "does not belong to this content: the file was changed after the fit; "
            "extract it anew or remove the hash"
        )
        problems = [(("provenance", "hash"), text)]
    if problems:
        raise SceneError([f"{origin.place(path)}: {text}" for path, text in problems])
    return closure


def _contradictions(table: Content) -> Iterator[tuple[KeyPath, str]]:
    """Yield what is wrong although each value may be right."""
    known = ARGUMENTS[table.closure]
    if table.form == "power" and table.closure != "nusselt":
        yield ("form",), f"is for a nusselt; a {table.closure} is a log_polynomial"
    if table.form == "power" and table.parameters is None:
        yield ("parameters",), "missing; a power has base, a, b and c"
    if table.form != "power" and not (table.variables and table.terms):
        yield ("terms",), "a log_polynomial needs [variables] and [[terms]]"
    for place, keys in (("variables", table.variables), ("range", table.range)):
        for key in keys:
            if not set(key.split("/")) <= set(known) or key.count("/") > 1:
                names = ", ".join(known)
                yield (place, key), f"names no argument of a {table.closure}; {names}"
    for name in table.names:
        if name not in table.range:
            yield ("range",), f"does not bound {name}"
    for key, (low, _) in table.range.items():
        scaled = table.variables.get(key)
        if low < 0.0:
            yield ("range", key), f"begins below 0, where {key} never is"
        elif low == 0.0 and scaled is not None and scaled.scale == "log":
            yield ("range", key), "begins at 0, whose logarithm is infinite"
    for k, term in enumerate(table.terms):
        if len(term.powers) != len(table.variables):
            yield ("terms", k), f"needs {len(table.variables)} whole powers >= 0"


def _beyond(table: Content, closure: Transferred) -> Iterator[tuple[KeyPath, str]]:
    """Yield a corner of the range where the closure has no value or one below zero."""
    place = "parameters" if table.form == "power" else "terms"
    for corner in product(*(table.range[name] for name in table.names)):
        with np.errstate(all="ignore"):
            value = closure.at([np.float64(x) for x in corner])
        if not 0.0 <= value <= LARGEST:
            pairs = zip(table.names, corner, strict=True)
            at = ", ".join(f"{name} = {x:g}" for name, x in pairs)
            yield (place,), f"give {value:g} at {at}, which is no transport coefficient"
            return


def content_hash(content: Mapping[str, Any]) -> str:
    """Hash of what a closure file holds besides its provenance."""
    text = json.dumps(
        {key: value for key, value in content.items() if key != "provenance"},
        sort_keys=True,
    )
    return hashlib.sha256(text.encode()).hexdigest()[:16]
