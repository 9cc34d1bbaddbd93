"""Steps of a cascade: range that the bed visits, fits of the packings, runs of the bed,
parts of the uncertainty.

Parts, each a standard deviation of a result with all else at its best value:

    packing     over the packings, each with its own fit and porosity
    fit         over the joint distribution of the parameters that are fitted to all packings
    laws        over the laws of one particle, equally probable: a choice among models, no more
    scatter     half the difference of runs with closures a standard deviation of measured beds above and below
    KEY         half the difference of runs one standard uncertainty above and below
    mesh        difference to a finer mesh

The band is that of runs with all of them at random at once, the mesh excepted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.closures import registry
from contbed.closures.binding import bind
from contbed.closures.file import content_hash
from contbed.dem import extract
from contbed.errors import ContbedError, ConvergenceError, SceneError
from contbed.many.cascade import measured
from contbed.many.cascade.file import AT_PARTICLE, Cascade
from contbed.many.cascade.particles import DEGREE, Ensemble
from contbed.many.cascade.reactor import CONDUCTIVITY, NUSSELT
from contbed.many.quantities import number_of
from contbed.many.runs import case_of, compute, folder_of, known
from contbed.output.folder import SUMMARY
from contbed.output.shapes import Shape, Use, read_json
from contbed.scene.mesh import MeshFile

Range = tuple[float, float]

BAND = 0.90  # of the probability
PACKING = "packing"  # column of the number of a packing
FIT_SAMPLES = 12  # runs for the part of the fit
TIGHTER = 0.1  # factor of the tolerance of an automatic mesh for the part of the mesh
# Wakao and Funazkri's exponents; only the range that the first run visits is taken from
# it
FIRST_NUSSELT = {"base": 2.0, "a": 1.1, "b": 0.6, "c": 1.0 / 3.0}
# of Zehner and Schluender's conductivity as a polynomial of logarithms, for the same
# purpose
FIRST_DEGREE = 5
WIDEST = {"k_solid/k_fluid": (1e-2, 1e6), "Re": (1e-6, 1e7), "Pr": (1e-4, 1e5)}


@dataclass(frozen=True)
class Part:
    """A part of the uncertainty: what it is, and the standard deviation of each
    result in its unit.
    """

    name: str
    deviation: Mapping[str, float]


class BedClosure(Shape):
    """A closure of a run of the bed."""

    name: str
    share_outside: float
    ranges: dict[str, Use]


class BedSummary(Shape):
    """What is used of summary.json of a run of the bed."""

    closures: list[BedClosure]
    qoi: dict[str, Any]


@dataclass
class Runs:
    """Runs of the scene with closures from packings, kept by the hash of their
    scenes.
    """

    cascade: Cascade
    folder: Path
    told: Callable[[], None]
    retry_failed: bool = False
    before: int = 0
    seen: set[str] = field(default_factory=set)
    failed: list[str] = field(default_factory=list)
    outside: set[str] = field(default_factory=set)

    def results(
        self, fits: Mapping[str, extract.Fit], changes: Mapping[str, Any]
    ) -> dict[str, float] | None:
        """Return the results asked for with fitted closures by their kind; None if
        the run failed.
        """
        folder = self.run(fits, changes)
        if folder is None:
            return None
        summary = self.summary(folder)
        for closure in summary["closures"]:
            if closure["share_outside"] > 0 and closure["name"].endswith(".toml"):
                self.outside.add(folder.name)
        found = {
            name: float(summary["qoi"][name]) for name in self.cascade.settings.qoi
        }
        if self.cascade.measured is not None:
            found |= measured.predicted(self.cascade.measured, folder)
        return found

    def summary(self, folder: Path) -> dict[str, Any]:
        """Return the summary of a run, which has all results that are asked for.

        Raises
        ------
        SceneError : it lacks one
        ContbedError : it is damaged
        """
        remedy = f"remove {folder}, and the same command computes it again"
        summary = read_json(
            folder / SUMMARY, BedSummary, "the summary of a run", remedy
        )
        for name in self.cascade.settings.qoi:
            number_of(summary["qoi"], name, f"{self.cascade.path}: qoi")
        return summary

    def run(
        self, fits: Mapping[str, extract.Fit], changes: Mapping[str, Any]
    ) -> Path | None:
        """Run the scene, or find its run; return its folder, or None if it failed."""
        cascade = self.cascade
        places = cascade.reactor.places
        files = {
            key: {"file": str(self._written(fit))}
            for kind, fit in fits.items()
            for key in places[kind]
        }
        output: dict[str, Any] = {"output.plots": False, "output.fields": False}
        if cascade.measured is not None:
            output |= measured.outputs(cascade.measured)
        case = case_of(cascade.load({**output, **files, **changes}), {})
        outcome = known(case, self.folder, self.retry_failed)
        self.before += outcome is not None and case.name not in self.seen
        self.seen.add(case.name)
        outcome = outcome or compute(case, self.folder)
        self.told()
        if outcome["exit_code"]:
            self.failed.append(f"run {case.name}: {outcome['problem']}")
            return None
        return folder_of(case, self.folder)

    def _written(self, fit: extract.Fit) -> Path:
        path = (
            self.folder / "closures" / f"{content_hash(fit.content)}.toml"
        ).absolute()
        if not path.is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            fit.write(path, {"scene": self.cascade.path.name})
        return path


def visited(runs: Runs) -> dict[str, Range]:
    """Return the ranges of k_solid/k_fluid, Re and Pr that the bed visits with
    closures of the literature.
    """
    cascade = runs.cascade
    eps = cascade.reactor.porosity
    fits: dict[str, extract.Fit] = {}
    if cascade.settings.laws.conduction:
        ratios = np.geomspace(*WIDEST["k_solid/k_fluid"], 25)
        k = registry.get("conductivity_zehner_schluender")(
            k_fluid=1.0, k_solid=ratios, eps=eps
        )
        fits[CONDUCTIVITY] = _polynomial({extract.RATIO: ratios}, k, FIRST_DEGREE)
    if cascade.settings.laws.exchange:
        parameters = {
            name: {"value": value, "given": True}
            for name, value in FIRST_NUSSELT.items()
        }
        content = {
            "format": 1,
            "kind": "nusselt",
            "form": "power",
            "parameters": parameters,
        }
        content["range"] = {name: list(WIDEST[name]) for name in ("Re", "Pr")}
        fits[NUSSELT] = extract.Fit(content, np.zeros((0, 0)), np.zeros(0))
    folder = runs.run(fits, {})
    if folder is None:
        raise ConvergenceError(
            f"{cascade.scene_file}: the first run failed: {runs.failed[-1]}"
        )
    summary = runs.summary(folder)
    found: dict[str, Range] = {}
    for closure in summary["closures"]:
        if not closure["name"].endswith(".toml"):
            continue
        for name, use in closure["ranges"].items():
            # solid phases of a bubbling bed have a range each
            low, high = found.get(name, (np.inf, -np.inf))
            found[name] = (
                min(low, float(use["used"][0])),
                max(high, float(use["used"][1])),
            )
    return found


@dataclass(frozen=True)
class Fits:
    """Closures fitted to packings: to one of them or to all, by a law of conduction
    and one of exchange.
    """

    ensemble: Ensemble
    ranges: Mapping[str, Range]

    @property
    def choices(self) -> tuple[int, int]:
        """How many laws of conduction and of exchange there are, at least one of
        each.
        """
        laws = self.ensemble.cascade.settings.laws
        return max(1, len(laws.conduction)), max(1, len(laws.exchange))

    def of(
        self, beds: list[int], conduction: int = 0, exchange: int = 0
    ) -> dict[str, extract.Fit]:
        """Return the fits by their kind."""
        laws, found = self.ensemble.cascade.settings.laws, {}
        if laws.conduction:
            ratios = self.ranges[extract.RATIO]
            columns = _together(
                [
                    self.ensemble.conduction(bed, laws.conduction[conduction], ratios)
                    for bed in beds
                ]
            )
            k = columns.pop("k/k_fluid")
            found[CONDUCTIVITY] = _polynomial(columns, k, DEGREE)
        if laws.exchange:
            ranges = self.ranges["Re"], self.ranges["Pr"]
            columns = _together(
                [self.ensemble.exchange(bed, exchange, *ranges) for bed in beds]
            )
            found[NUSSELT] = extract.fit_power(
                columns["Re"], columns["Pr"], columns["Nu"]
            )
        return found


def _polynomial(columns: Mapping[str, Array], k: Array, degree: int) -> extract.Fit:
    return extract.fit_log_polynomial(
        "conductivity", columns, k, {extract.RATIO: "log"}, (degree,)
    )


def _together(parts: list[dict[str, Array]]) -> dict[str, Array]:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def drawn(
    fits: Mapping[str, extract.Fit], count: int, seed: int
) -> list[dict[str, extract.Fit]]:
    """Return fits whose parameters follow their joint normal distribution."""
    samples = {key: fit.samples(count, seed) for key, fit in fits.items()}
    return [
        {
            key: replace(fits[key], content=dict(of[n].content))
            for key, of in samples.items()
        }
        for n in range(count)
    ]


def parts_of(runs: Runs, fits: Fits, base: Mapping[str, float]) -> list[Part]:
    """Return the parts of the uncertainty, each from runs with all else at its best
    value.

    Raises
    ------
    ContbedError : so many runs failed that a part has none
    """
    beds = list(range(len(fits.ensemble.beds)))
    porosity = float(fits.ensemble.porosities.mean())
    best, given = fits.of(beds), runs.cascade.reactor.at
    at = given(porosity)
    single = [
        runs.results(fits.of([bed]), given(float(fits.ensemble.porosities[bed])))
        for bed in beds
    ]
    fitted = [runs.results(one, at) for one in drawn(best, FIT_SAMPLES, seed=0)]
    found = [_spread("packing", single, lost=1), _spread("fit", fitted, lost=1)]
    for law, count in zip(("conduction", "exchange"), fits.choices, strict=True):
        if count > 1:
            chosen = [fits.of(beds, **{law: k}) for k in range(count)]
            results = [runs.results(one, at) for one in chosen]
            found.append(_spread(f"law of {law}", results))
    for kind, (name, scatter) in scatter_of(runs.cascade).items():
        ends = [
            runs.results(best | {kind: best[kind].times(np.exp(sign * scatter))}, at)
            for sign in (-1.0, 1.0)
        ]
        found.append(_spread(f"scatter of {name}", ends))
    for key, value, uncertainty in runs.cascade.uncertain:
        middle = at.get(key, value)
        ends = [
            runs.results(best, at | {key: middle + sign * uncertainty})
            for sign in (-1.0, 1.0)
        ]
        found.append(_spread(key, ends))
    found.append(_spread("mesh", [base, _on_finer_mesh(runs, best, at)], scale=2.0))
    return found


def scatter_of(cascade: Cascade) -> dict[str, tuple[str, float]]:
    """Return by kind of closure what scatters and the standard deviation of the
    logarithm of measured values.
    """
    laws = cascade.settings.laws
    there = {
        CONDUCTIVITY: ("conduction", laws.scatter_conduction),
        NUSSELT: ("exchange", laws.scatter_exchange),
    }
    return {kind: part for kind, part in there.items() if part[1] > 0.0}


def _on_finer_mesh(
    runs: Runs, fits: Mapping[str, extract.Fit], at: Mapping[str, Any]
) -> dict[str, float] | None:
    scene = runs.cascade.scene
    automatic = not isinstance(scene.mesh, MeshFile) and scene.mesh.cells is None
    key, value = (
        ("solver.tolerance", TIGHTER * scene.solver.tolerance)
        if automatic
        else ("mesh.refine", scene.mesh.refine + 1)
    )
    return runs.results(fits, {**at, key: value})


def _spread(name: str, results: list[Any], lost: int = 0, scale: float = 1.0) -> Part:
    """Return the standard deviation of each result; `lost` degrees of freedom are
    those of a mean from the sample.
    """
    there = [one for one in results if one is not None]
    if len(there) < 2:
        raise ContbedError(
            f"uncertainty by {name}: {len(there)} of {len(results)} runs succeeded, "
            "two are needed"
        )
    return Part(
        name,
        {
            q: scale * float(np.std([one[q] for one in there], ddof=lost))
            for q in there[0]
        },
    )


def sampled(runs: Runs, fits: Fits) -> tuple[dict[str, Array], dict[str, list[Any]]]:
    """Return each result of the runs with everything at random at once, and what was
    drawn; failed runs are left out.

    Returns
    -------
    samples : by result and measured point, (runs,)
    drawn : number of the packing, laws, factors of scatter, numbers of the scene in SI,
        by their names, (runs,)
    """
    cascade, laws = runs.cascade, fits.choices
    there = []
    for number in range(cascade.settings.samples):
        # each of its own: more can be added
        random = np.random.default_rng([cascade.settings.packings.seed, number])
        bed = int(random.integers(len(fits.ensemble.beds)))
        chosen = [int(random.integers(count)) for count in laws]
        one = drawn(fits.of([bed], *chosen), 1, seed=int(random.integers(2**31)))[0]
        changes = cascade.reactor.at(float(fits.ensemble.porosities[bed]))
        for key, value, uncertainty in cascade.uncertain:
            middle = changes.get(key, value)
            changes[key] = float(middle + uncertainty * random.standard_normal())
        factors = {}
        for kind, (name, scatter) in scatter_of(cascade).items():
            factor = float(np.exp(scatter * random.standard_normal()))
            one[kind] = one[kind].times(factor)
            factors[f"laws.scatter_{name}"] = factor
        results = _or_failed(runs, one, changes)
        if results is not None:
            there.append(
                (
                    {PACKING: bed + 1} | _named(cascade, *chosen) | factors | changes,
                    results,
                )
            )
    if len(there) < 2:
        count = cascade.settings.samples
        raise ContbedError(
            f"{len(there)} of {count} samples succeeded; the first problem: "
            f"{runs.failed[0]}"
        )
    samples = {
        name: np.array([results[name] for _, results in there]) for name in there[0][1]
    }
    return samples, {
        name: [inputs[name] for inputs, _ in there] for name in there[0][0]
    }


def _named(cascade: Cascade, conduction: int, exchange: int) -> dict[str, str]:
    """Return the laws that were drawn, by their names, where there is a choice."""
    laws = cascade.settings.laws
    found: dict[str, str] = {}
    if len(laws.conduction) > 1:
        found["laws.conduction"] = laws.conduction[conduction]
    if len(laws.exchange) > 1:
        law = bind(laws.exchange[exchange], "nusselt", AT_PARTICLE)
        parameters = (f"{name} = {value:g}" for name, value in law.parameters.items())
        found["laws.exchange"] = ", ".join(
            [law.sheet.name.removeprefix("nusselt_"), *parameters]
        )
    return found


def _or_failed(
    runs: Runs, fits: Mapping[str, extract.Fit], changes: Mapping[str, Any]
) -> dict[str, float] | None:
    """Return the results; None where the numbers that were drawn make no scene,
    which is noted.
    """
    try:
        return runs.results(fits, changes)
    except SceneError as error:
        if any(key in str(error) for key in changes):
            runs.failed.append("; ".join(error.problems))
            return None
        raise
