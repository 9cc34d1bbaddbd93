"""From particles to closures: sweeps over packings, smooth fits with confidence
intervals, closure files.

The forms and the file are those of `contbed.closures.transferred`, which reads them
back for a scene.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import curve_fit
from scipy.stats import t as student

from contbed import __version__
from contbed.arrays import Array
from contbed.closures.file import content_hash
from contbed.closures.transferred import FORMAT, Transferred
from contbed.dem import heat, network
from contbed.errors import SceneError
from contbed.output.files import atomic
from contbed.output.toml_text import toml_text

CONFIDENCE = 0.95
RATIO = "k_solid/k_fluid"


class Packing(NamedTuple):
    """A bed whose conductivity is measured between its particles below `bottom` and
    above `top` [m].

    `radius`: of all particles, or (n,). `box`: corners of a box that is periodic in x
    and y; None for walls at the outermost particles.
    """

    x: Array
    radius: float | Array
    porosity: float
    bottom: float
    top: float
    area: float
    box: heat.Box | None = None


@dataclass(frozen=True)
class Fit:
    """A fitted closure: `content` is its file without provenance; `covariance` that
    of the fitted parameters.
    """

    content: dict[str, Any]
    covariance: Array
    residuals: Array

    def closure(self, name: str = "fit") -> Transferred:
        """Return the closure as a function of keywords."""
        return Transferred(name, self.content)

    def samples(self, count: int, seed: int) -> list[Transferred]:
        """Draw closures whose parameters follow their joint normal distribution."""
        rng = np.random.default_rng(seed)
        parts = _fitted(self.content)
        drawn = rng.multivariate_normal(
            [part["value"] for part in parts], self.covariance, count
        )
        closures = []
        for values in drawn:
            content = json.loads(json.dumps(self.content))
            for part, value in zip(_fitted(content), values, strict=True):
                part["value"] = float(value)
            closures.append(Transferred("sample", content))
        return closures

    def times(self, factor: float) -> Fit:
        """Return the fit with all of its values multiplied by a factor > 0."""
        content = json.loads(json.dumps(self.content))
        if content["form"] == "power":
            for name in ("base", "a"):
                content["parameters"][name]["value"] *= factor
        else:
            next(term for term in content["terms"] if not any(term["powers"]))[
                "value"
            ] += float(np.log(factor))
        return replace(self, content=content)

    def write(self, path: Path | str, provenance: Mapping[str, Any]) -> None:
        """Write the closure file. The version and a hash of the fitted content are
        added to `provenance`.
        """
        origin = {
            **provenance,
            "contbed": __version__,
            "hash": content_hash(self.content),
        }
        with atomic(path) as temporary:
            temporary.write_text(
                toml_text({**self.content, "provenance": origin}), encoding="utf-8"
            )


def conductivity_sweep(
    packings: Iterable[Packing],
    ratios: Sequence[float],
    k_fluid: float,
    factor: float,
    paths: str = "cones",
) -> dict[str, Array]:
    """Find the effective conductivity of each packing at each ratio: columns `eps`,
    `k_solid/k_fluid`, `k/k_fluid`.

    `factor` is the correction c of the contact radius, `paths` as in `heat.Conduction`.
    """
    rows = []
    for packing in packings:
        x, R = packing.x, packing.radius
        largest = float(np.max(R))
        box = packing.box or (x.min(axis=0) - largest, x.max(axis=0) + largest)
        sides = packing.box is not None
        if paths in heat.VORONOI:
            pairs = heat.voronoi_pairs(x, box, (sides, sides, False))
        else:
            pairs = heat.near_pairs(x, 3.0 * largest, box, (sides, sides, False))
        hot, cold = x[:, 2] < packing.bottom, x[:, 2] > packing.top
        for ratio in ratios:
            how = heat.Conduction(
                ratio * k_fluid,
                k_fluid,
                packing.porosity,
                factor,
                paths=paths,  # type: ignore[arg-type]
            )
            result = network.between_layers(
                x, pairs, heat.conductances(pairs, R, how), hot, cold, packing.area
            )
            rows.append((packing.porosity, ratio, result.conductivity / k_fluid))
    return dict(zip(("eps", RATIO, "k/k_fluid"), np.array(rows).T.copy(), strict=True))


def fit_log_polynomial(
    kind: str,
    columns: Mapping[str, ArrayLike],
    y: ArrayLike,
    scales: Mapping[str, str],
    degrees: Sequence[int],
) -> Fit:
    """Fit ln(y) by least squares in products of the variables up to these degrees.

    Parameters
    ----------
    kind : "conductivity", y is k/k_fluid, or "nusselt"
    columns : data by name; those not in `scales` only widen the declared range
    scales : "log" or "linear" of each variable of the fit
    degrees : highest power of each variable

    Raises
    ------
    SceneError : the data do not determine the parameters
    """
    data = {name: np.asarray(column, dtype=float) for name, column in columns.items()}
    target = np.log(np.asarray(y, dtype=float))
    references = {name: _reference(data[name], scale) for name, scale in scales.items()}
    scaled = [
        np.log(data[name] / references[name])
        if scale == "log"
        else data[name] - references[name]
        for name, scale in scales.items()
    ]
    powers = list(product(*(range(degree + 1) for degree in degrees)))
    matrix = np.stack(
        [
            np.prod([s**p for s, p in zip(scaled, term, strict=True)], axis=0)
            for term in powers
        ],
        axis=1,
    )
    free = len(target) - len(powers)
    # columns of like size, so that the rank is a matter of the data alone
    size = np.abs(matrix).max(axis=0)
    if (
        free < 1
        or (size == 0).any()
        or np.linalg.matrix_rank(matrix / size) < len(powers)
    ):
        raise SceneError(
            f"{len(target)} points do not determine {len(powers)} terms of degrees "
            f"{tuple(degrees)} in "
            f"{', '.join(scales)}: lower a degree or add points"
        )
    values = np.linalg.lstsq(matrix / size, target, rcond=None)[0] / size
    residuals = target - matrix @ values
    inverse = np.linalg.inv((matrix / size).T @ (matrix / size)) / np.outer(size, size)
    covariance = inverse * float(residuals @ residuals) / free
    estimates = _estimates(values, covariance, free)
    form = {
        "format": FORMAT,
        "kind": kind,
        "form": "log_polynomial",
        "variables": {
            name: {"scale": scale, "reference": references[name]}
            for name, scale in scales.items()
        },
        "terms": [
            {"powers": list(term), **estimate}
            for term, estimate in zip(powers, estimates, strict=True)
        ],
    }
    what = "of ln(k/k_fluid)" if kind == "conductivity" else "of ln(Nu)"
    return _fit(form, data, covariance, residuals, what)


def fit_power(
    Re: ArrayLike, Pr: ArrayLike, Nu: ArrayLike, base: float = 2.0, c: float = 1 / 3
) -> Fit:
    """Fit a and b of Nu = base + a Re^b Pr^c by least squares; `base` and `c` are
    given.
    """
    Re, Pr, Nu = np.broadcast_arrays(
        *(np.asarray(column, dtype=float) for column in (Re, Pr, Nu))
    )
    free = Re.size - 2
    if free < 1 or np.ptp(Re) == 0:
        raise SceneError(
            f"{Re.size} points from Re {Re.min():g} to {Re.max():g} do not determine a "
            "and b"
        )

    def model(Re: Array, a: float, b: float) -> Array:
        return base + a * Re**b * Pr**c

    lifted = np.maximum(Nu - base, 1e-3) / Pr**c
    b, log_a = np.polyfit(np.log(Re), np.log(lifted), 1)
    (a, b), covariance = curve_fit(
        model, Re, Nu, p0=(np.exp(log_a), b), xtol=1e-14, ftol=1e-14
    )
    residuals = Nu - model(Re, a, b)
    factor, power = _estimates((a, b), covariance, free)
    form = {
        "format": FORMAT,
        "kind": "nusselt",
        "form": "power",
        "parameters": {
            "base": {"value": base, "given": True},
            "a": factor,
            "b": power,
            "c": {"value": c, "given": True},
        },
    }
    return _fit(form, {"Re": Re, "Pr": Pr}, covariance, residuals, "of Nu")


def _fitted(content: Mapping[str, Any]) -> list[dict[str, Any]]:
    parts = content["terms"] if "terms" in content else content["parameters"].values()
    return [part for part in parts if not part.get("given")]


def _reference(column: Array, scale: str) -> float:
    """Choose a round number in the middle of the data, so that the terms are little
    correlated.
    """
    middle = np.exp(np.log(column).mean()) if scale == "log" else column.mean()
    return float(f"{middle:.3g}")


def _estimates(values: ArrayLike, covariance: Array, free: int) -> list[dict[str, Any]]:
    """Return values with their intervals of confidence."""
    quantile = student.ppf(0.5 + 0.5 * CONFIDENCE, free)
    half = quantile * np.sqrt(np.diag(covariance))
    return [
        {"value": float(v), "interval": [float(v - h), float(v + h)]}
        for v, h in zip(np.asarray(values), half, strict=True)
    ]


def _fit(
    form: dict[str, Any],
    data: Mapping[str, Array],
    covariance: Array,
    residuals: Array,
    what: str,
) -> Fit:
    """Add the ranges of the data and a summary of the residuals to a form."""
    ranges = {
        name: [float(column.min()), float(column.max())]
        for name, column in data.items()
    }
    summary = {
        "what": what,
        "points": int(residuals.size),
        "rms": float(np.sqrt(np.mean(residuals**2))),
        "largest": float(np.abs(residuals).max()),
        "confidence": CONFIDENCE,
    }
    return Fit({**form, "range": ranges, "residuals": summary}, covariance, residuals)
