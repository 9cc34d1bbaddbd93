"""Error of estimators of uncertainty over the number of runs, on two problems with
known answers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.many import value_sets
from contbed.many.distributions import HALF_WIDTH, Distribution
from contbed.many.uncertainty.indices import indices
from contbed.many.uncertainty.polynomial_chaos import (
    chaos_indices,
    chaos_spread,
    expansion,
)
from contbed.many.uncertainty.propagate import (
    contributions,
    first_order,
    independent,
    of_sample,
)
from studies import _gallery as gallery
from studies._gallery import Table, Tables

Array = NDArray[np.float64]
RUNS = (40, 160, 640, 2560, 10240)  # about; each design takes what it needs
CHAOS_RUNS = (16, 32, 64, 128, 256)
SEEDS = 20  # of each design; errors are root mean squares over them
# Gauss points along each parameter, with which the answers of the pressure drop have
# settled to 1e-10
ORDER = 40
STEP = 1e-4  # of the derivatives, in standard deviations
NOT_COMPARED = ("CPU [s]",)
SAMPLED = ("latin_hypercube", "sobol", "sobol_indices")
# bed of 2 m in a gas of 1.2 kg/m3 at 0.1 m/s
LENGTH, DENSITY, VELOCITY = 2.0, 1.2, 0.1


def ishigami(x: Array) -> Array:
    """Ishigami and Homma's function with a = 7 and b = 0.1, x of shape (runs, 3)."""
    return (
        np.sin(x[:, 0])
        + 7.0 * np.sin(x[:, 1]) ** 2
        + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    )


def pressure_drop(x: Array) -> Array:
    """Ergun's equation [Pa]; porosity, diameter [m] and viscosity [Pa s] of shape
    (runs, 3).
    """
    porosity, diameter, viscosity = x.T
    share = (1.0 - porosity) / porosity**3
    viscous = 150.0 * viscosity * (1.0 - porosity) * VELOCITY / diameter**2
    return LENGTH * share * (viscous + 1.75 * DENSITY * VELOCITY**2 / diameter)


@dataclass(frozen=True)
class Problem:
    """A function of independent parameters."""

    function: Callable[[Array], Array]
    distributions: dict[str, Distribution]

    def at(self, u: Array) -> Array:
        """Values at points of the unit cube."""
        return self.function(
            np.column_stack(
                [s(u[:, k]) for k, s in enumerate(self.distributions.values())]
            )
        )

    def gradient(self) -> tuple[float, Array]:
        """Value and derivatives at the means, as a tangent gives them."""
        means = np.array([spread.mean for spread in self.distributions.values()])
        steps = STEP * np.diag(
            [spread.deviation for spread in self.distributions.values()]
        )
        slopes = (self.function(means + steps) - self.function(means - steps)) / (
            2.0 * np.diag(steps)
        )
        return float(self.function(means[None])[0]), slopes


PROBLEMS = {
    "Ishigami": Problem(
        ishigami, {f"x{k}": Distribution(-np.pi, np.pi, even=True) for k in (1, 2, 3)}
    ),
    "pressure drop": Problem(
        pressure_drop,
        {
            "porosity": Distribution(0.39, 0.41, even=True),
            "diameter": Distribution(3e-3, 3.1e-3, even=False),
            "viscosity": Distribution(2e-5, 2.1e-5, even=False),
        },
    ),
}


@cache
def reference(name: str) -> dict[str, Array | float]:
    """Mean, standard deviation, first-order and total indices: in closed form, or by
    Gauss quadrature.
    """
    if name == "Ishigami":
        variance = 49.0 / 8.0 + 0.1 * np.pi**4 / 5.0 + 0.01 * np.pi**8 / 18.0 + 0.5
        first = (
            np.array([0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 49.0 / 8.0, 0.0])
            / variance
        )
        both = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0) / variance
        return {
            "mean": 3.5,
            "deviation": variance**0.5,
            "first": first,
            "total": first + both * np.array([1, 0, 1]),
        }
    problem = PROBLEMS[name]
    nodes, weights = [], []
    for spread in problem.distributions.values():
        if spread.even:
            x, w = np.polynomial.legendre.leggauss(ORDER)
            nodes.append(spread.value(HALF_WIDTH * x))
        else:
            x, w = np.polynomial.hermite_e.hermegauss(ORDER)
            nodes.append(spread.value(x))
        weights.append(w / w.sum())
    grid = np.stack(
        [axis.ravel() for axis in np.meshgrid(*nodes, indexing="ij")], axis=1
    )
    values = problem.function(grid).reshape([ORDER] * 3)

    def mean(of: Array, axes: tuple[int, ...]) -> Array:
        for axis in sorted(axes, reverse=True):
            of = np.tensordot(of, weights[axis], (axis, 0))
        return of

    middle = float(mean(values, (0, 1, 2)))
    variance = float(mean((values - middle) ** 2, (0, 1, 2)))
    first, total = np.empty(3), np.empty(3)
    for k in range(3):
        others = tuple(j for j in range(3) if j != k)
        first[k] = float(weights[k] @ (mean(values, others) - middle) ** 2) / variance
        rest = mean(values, (k,)) - middle
        inner = np.einsum("i,j,ij->", weights[others[0]], weights[others[1]], rest**2)
        total[k] = 1.0 - float(inner) / variance
    return {"mean": middle, "deviation": variance**0.5, "first": first, "total": total}


def compute() -> Tables:
    """Errors of each estimator over the number of runs."""
    rows: list[list[Any]] = []
    for name, problem in PROBLEMS.items():
        rows.append(_by_gradient(name, problem))
        rows += [
            _by_design(name, problem, method, runs)
            for method in SAMPLED
            for runs in RUNS
        ]
        rows += [_by_chaos(name, problem, runs) for runs in CHAOS_RUNS]
        rows += [_by_morris(name, problem, runs) for runs in RUNS[:2]]
    form = {"problem": "", "estimator": "", "runs": "d"} | dict.fromkeys(
        (
            "error of the mean",
            "error of the deviation",
            "error of first order",
            "error of total",
        ),
        ".3e",
    )
    exact = [
        [
            name,
            float(answer["mean"]),
            float(answer["deviation"]),
            *answer["first"],
            *answer["total"],
        ]
        for name in PROBLEMS
        for answer in [reference(name)]
    ]
    heads = [
        "mean",
        "deviation",
        *(f"first order {k}" for k in (1, 2, 3)),
        *(f"total {k}" for k in (1, 2, 3)),
    ]
    return {
        "results": Table(form | {"parameters in order": "", "CPU [s]": ".3f"}, rows),
        "exact": Table({"problem": ""} | dict.fromkeys(heads, ".8g"), exact),
    }


def _rms(errors: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


def _by_gradient(name: str, problem: Problem) -> list[Any]:
    answer, start = reference(name), gallery.user_time()
    value, slopes = problem.gradient()
    spread = first_order(value, slopes, problem.distributions, 1)
    shares = contributions(slopes, problem.distributions) ** 2 / spread.deviation**2
    seconds = gallery.user_time() - start
    scale = float(answer["deviation"])
    order = bool((np.argsort(shares) == np.argsort(answer["total"])).all())
    return [name, "gradients", 1, abs(spread.mean - float(answer["mean"])) / scale, abs(spread.deviation / scale - 1.0),
            float(np.abs(shares - answer["first"]).max()), float(np.abs(shares - answer["total"]).max()),
            "yes" if order else "no", seconds]  # fmt: skip


def _by_design(name: str, problem: Problem, method: str, runs: int) -> list[Any]:
    answer, scale = reference(name), float(reference(name)["deviation"])
    count = runs // 5 if method == "sobol_indices" else runs
    count = 2 ** round(np.log2(count)) if method.startswith("sobol") else count
    errors: dict[str, list[float]] = {
        "mean": [],
        "deviation": [],
        "first": [],
        "total": [],
    }
    right, used, start = 0, 0, gallery.user_time()
    for seed in range(SEEDS):
        points = value_sets.sample(method, count, seed, 3)
        values, used = problem.at(points), len(points)
        spread = of_sample(values[independent(method, points)])
        assert spread is not None, "all runs have values"
        errors["mean"].append((spread.mean - float(answer["mean"])) / scale)
        errors["deviation"].append(spread.deviation / scale - 1.0)
        if method == "sobol_indices":
            found = indices(method, points, values)
            assert found is not None, "there are enough groups"
            errors["first"].append(
                float(np.abs(found.columns["first order"] - answer["first"]).max())
            )
            errors["total"].append(
                float(np.abs(found.columns["total"] - answer["total"]).max())
            )
            right += bool(
                (
                    np.argsort(found.columns["total"]) == np.argsort(answer["total"])
                ).all()
            )
    seconds = (gallery.user_time() - start) / SEEDS
    parts = [_rms(each) if each else None for each in errors.values()]
    return [
        name,
        method,
        used,
        *parts,
        f"{right} of {SEEDS}" if errors["first"] else None,
        seconds,
    ]


def _by_chaos(name: str, problem: Problem, runs: int) -> list[Any]:
    """Polynomial chaos of Sobol points; the errors are those of the seeds in which
    it trusts its polynomial.
    """
    answer, scale = reference(name), float(reference(name)["deviation"])
    errors: dict[str, list[float]] = {
        "mean": [],
        "deviation": [],
        "first": [],
        "total": [],
    }
    right, start = 0, gallery.user_time()
    for seed in range(SEEDS):
        points = value_sets.sample("sobol", runs, seed, 3)
        chaos = expansion(
            points, problem.at(points), list(problem.distributions.values())
        )
        if chaos is None:
            continue
        spread, columns = chaos_spread(chaos), chaos_indices(chaos).columns
        errors["mean"].append((spread.mean - float(answer["mean"])) / scale)
        errors["deviation"].append(spread.deviation / scale - 1.0)
        errors["first"].append(
            float(np.abs(columns["first order"] - answer["first"]).max())
        )
        errors["total"].append(float(np.abs(columns["total"] - answer["total"]).max()))
        right += bool(
            (np.argsort(columns["total"]) == np.argsort(answer["total"])).all()
        )
    seconds = (gallery.user_time() - start) / SEEDS
    parts = [_rms(each) if each else None for each in errors.values()]
    return [
        name,
        "polynomial_chaos",
        runs,
        *parts,
        f"{right} of {len(errors['mean'])}",
        seconds,
    ]


def _by_morris(name: str, problem: Problem, runs: int) -> list[Any]:
    answer, right, used, start = reference(name), 0, 0, gallery.user_time()
    for seed in range(SEEDS):
        points = value_sets.sample("morris", runs // 4, seed, 3)
        points = np.column_stack(
            [
                value_sets.within_tails(points[:, k], spread)
                for k, spread in enumerate(problem.distributions.values())
            ]
        )
        used = len(points)
        found = indices("morris", points, problem.at(points))
        assert found is not None, "there are enough ways"
        right += bool(
            (
                np.argsort(found.columns["mean magnitude"])
                == np.argsort(answer["total"])
            ).all()
        )
    seconds = (gallery.user_time() - start) / SEEDS
    return [
        name,
        "morris",
        used,
        None,
        None,
        None,
        None,
        f"{right} of {SEEDS}",
        seconds,
    ]


def plot(tables: Tables) -> dict[str, Any]:
    """Error of the standard deviation, and of the total indices, over the number of
    runs.
    """
    figure, panels = gallery.figure(1, 2, sharey=True)
    table = tables["results"]
    for axes, name in zip(panels, PROBLEMS, strict=True):
        for k, method in enumerate(("gradients", *SAMPLED, "polynomial_chaos")):
            rows = table.where({"problem": name, "estimator": method})
            axes.loglog(rows["runs"], rows["error of the deviation"], "o-", color=gallery.PALETTE[k],
                        label=f"deviation, {method}")  # fmt: skip
        for k, method in (
            (0, "gradients"),
            (3, "sobol_indices"),
            (4, "polynomial_chaos"),
        ):
            rows = table.where({"problem": name, "estimator": method})
            axes.loglog(rows["runs"], rows["error of total"], "s--", color=gallery.PALETTE[k],
                        label=f"total indices, {method}")  # fmt: skip
        axes.set(title=name, xlabel="runs")
    panels[0].set(ylabel="error, relative or of a share")
    panels[0].legend(fontsize=7)
    return {"estimators": figure}
