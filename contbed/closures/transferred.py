"""Closures fitted from particle models: what stands in a closure file, as a function
like the published ones.

A closure file is TOML that `contbed.dem.extract` writes and `contbed.closures.file`
reads:

    format = 1
    kind = "conductivity"                # or "nusselt", or "bed_tube"
    form = "log_polynomial"              # or "power", of a nusselt
    [variables]                          # in the order of the powers
    "k_solid/k_fluid" = {scale = "log", reference = 1.0}
    eps = {scale = "linear", reference = 0.4}
    [[terms]]                            # log_polynomial
    powers = [1, 0]
    value = 0.72
    interval = [0.70, 0.74]              # 95 %
    [range]
    "k_solid/k_fluid" = [1.0, 1000.0]
    [residuals] and [provenance]         # for people

Forms, both smooth inside of their range and differentiable by dual numbers:

    log_polynomial:  ln(y/unit) = sum of value * product of t_v^power,  t = ln(v/reference) or v - reference
    power:           Nu = base + a Re^b Pr^c, [parameters] base, a, b, c with value and interval

with y = k and unit k_fluid for a conductivity, y = Nu and unit 1 for a nusselt, y = h
and unit 1 W/m2/K for a bed_tube. The range may bound further arguments on which the fit
does not depend. It is declared, not enforced: like that of any closure its use outside
is reported, or an error in strict mode.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from contbed.closures.sheet import Sheet

FORMAT = 1
UNITS = {"conductivity": "W/m/K", "nusselt": "-", "bed_tube": "W/m2/K"}
ARGUMENTS = {
    "conductivity": ("k_fluid", "k_solid", "eps", "T", "d_p"),
    "nusselt": ("Re", "Pr", "eps"),
    "bed_tube": ("eps", "T", "d_p", "k_gas"),
}


class Transferred:
    """A closure from a file: callable with keywords, with a data sheet, as the
    registered closures are.
    """

    def __init__(self, name: str, content: Mapping[str, Any]):
        kind, form = content["kind"], content["form"]
        self.content = content
        provenance = content.get("provenance", {})
        ranges = {
            key: (float(low), float(high))
            for key, (low, high) in content["range"].items()
        }
        used = {
            part for key in (*self._variables(), *ranges) for part in key.split("/")
        }
        if kind == "conductivity":
            used.add("k_fluid")
        arguments = tuple(argument for argument in ARGUMENTS[kind] if argument in used)
        source = (
            "; ".join(f"{key} {value}" for key, value in provenance.items())
            or "no provenance given"
        )
        self.sheet = Sheet(
            name=f"{kind} of {name}",
            kind=kind,
            unit=UNITS[kind],
            arguments=arguments,
            options=MappingProxyType({}),
            ranges=MappingProxyType(ranges),
            source=source,
            summary=f"Fitted from particles: {form}.",
            equation=form,
            text=f"{form} fitted from particles, {source}",
            bounds=MappingProxyType({}),
        )
        self.__signature__ = inspect.Signature(
            [
                inspect.Parameter(argument, inspect.Parameter.KEYWORD_ONLY)
                for argument in arguments
            ]
        )

    def __call__(self, **arguments: Any) -> Any:
        """Return the value of the fit for its arguments by name."""
        unit = arguments["k_fluid"] if self.sheet.kind == "conductivity" else 1.0
        return unit * self.at([_argument(key, arguments) for key in self._variables()])

    def at(self, variables: Sequence[Any]) -> Any:
        """Return the value over its unit where its variables have these values."""
        if self.content["form"] == "power":
            value = {
                key: part["value"] for key, part in self.content["parameters"].items()
            }
            powers = variables[0] ** value["b"] * variables[1] ** value["c"]
            return value["base"] + value["a"] * powers
        scaled = [
            np.log(x / rule["reference"])
            if rule["scale"] == "log"
            else x - rule["reference"]
            for x, rule in zip(
                variables, self.content["variables"].values(), strict=True
            )
        ]
        exponent: Any = 0.0
        for term in self.content["terms"]:
            part = term["value"]
            for variable, power in zip(scaled, term["powers"], strict=True):
                part = part * variable**power if power else part
            exponent = exponent + part
        return np.exp(exponent)

    def _variables(self) -> tuple[str, ...]:
        return (
            ("Re", "Pr")
            if self.content["form"] == "power"
            else tuple(self.content["variables"])
        )


def _argument(key: str, arguments: Mapping[str, Any]) -> Any:
    top, _, bottom = key.partition("/")
    return arguments[top] / arguments[bottom] if bottom else arguments[top]
