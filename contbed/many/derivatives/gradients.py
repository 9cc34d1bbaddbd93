"""Gradient of named results with respect to continuous keys of a scene.

Steady scenes take the discrete tangent, in which mesh and discretisation stay as they
are: packed beds with and without computed flow and radiation, radiation alone, bubbling
beds with reactions and what settles, reacting beds, developed flow. Transient packed
beds take differences of runs that are repeated with the same mesh and time steps.
Fronts, ordinates, cycles, other transients and particles take differences of whole
runs; results that scatter come with the standard error of common seeds. Scenes on
DOLFINx take differences of whole runs, on any number of ranks.

The tangent costs one solution with known factors for each key and gives all results. An
adjoint would cost one for each result and give all keys: it would be cheaper where keys
are many more than results, as with a value in every cell.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.compiled.blas import single_blas
from contbed.errors import SceneError, UnlikeError
from contbed.many.derivatives import differences, tangent
from contbed.many.derivatives.differences import Slope
from contbed.many.derivatives.keys import Key, key
from contbed.many.quantities import number_of, why_unknown
from contbed.models import model_of
from contbed.result import Result
from contbed.runner import engine_named, run
from contbed.scene.names import several
from contbed.scene.tables import SceneBase

UNSURE = 1e-2  # relative error of a derivative beyond which it is reported
# share of the largest derivative of a result, both by relative changes, below which
# errors are not reported
SMALL = 1e-3


@dataclass(frozen=True)
class Gradient:
    """Derivatives of named results with respect to keys of a scene, in SI.

    Attributes
    ----------
    qoi, keys : names of the results, and dotted keys of the scene
    values : (n_qoi,) results of the scene
    at : (n_keys,) values of the keys
    derivatives : (n_qoi, n_keys)
    standard_errors : (n_qoi, n_keys) of differences of runs that scatter; None for all
        others
    method : "tangent" or "differences"
    notes : what to know: one-sided derivatives at bounds, derivatives that are not sure
    """

    qoi: tuple[str, ...]
    keys: tuple[str, ...]
    values: Array
    at: Array
    derivatives: Array
    standard_errors: Array | None
    method: str
    notes: tuple[str, ...] = ()

    @property
    def logarithmic(self) -> Array:
        """Relative derivatives, d ln qoi/d ln key (n_qoi, n_keys) [1]; nan where the
        result is 0.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            found: Array = self.derivatives * self.at / self.values[:, None]
        found[~np.isfinite(found)] = np.nan
        return found


def gradient(
    scene: SceneBase,
    qoi: str | Sequence[str],
    keys: str | Sequence[str],
    engine: str = "skfem",
) -> Gradient:
    """Return the derivatives of named results with respect to keys of a scene.

    Parameters
    ----------
    scene : from `contbed.load`
    qoi : one or several named results, as in summary.json, "T_fluid_out_K"
    keys : one or several continuous keys of the scene, "packed_bed.porosity", "gas.viscosity",
        "boundary.left.gas.velocity[1]"
    engine : as of `contbed.run`; "dolfinx" is called on all ranks; all but rank 0
        return None

    Raises
    ------
    SceneError : a key has no derivative, a result does not exist; with the nearest name
    ContbedError : the scene, or the scene with a key a little changed, cannot be solved

    Examples
    --------
    >>> from contbed.loading import load
    >>> from contbed.models import MODELS
    >>> scene = load(MODELS["packed_bed"].template)
    >>> found = gradient(scene, "T_fluid_out_K", "boundary.left.gas.temperature")
    >>> f"{found.derivatives[0, 0]:.3f}"  # K of the outlet for one of the inlet
    '0.112'
    """
    qoi, keys = several(qoi), several(keys)
    require_possible(scene, qoi, keys)
    return engine_named(engine).run(
        lambda: gradient_of(run(scene, engine=engine), qoi, keys)
    )


def require_possible(scene: SceneBase, qoi: Sequence[str], keys: Sequence[str]) -> None:
    """Raise SceneError, before anything is solved, for a key without derivative or a
    name that no result has.
    """
    model_of(scene)
    for name in keys:
        key(scene, name)
    require_known(qoi)


def gradient_of(
    result: Result, qoi: str | Sequence[str], keys: str | Sequence[str]
) -> Gradient:
    """Return `gradient` for a scene that has been run.

    Raises
    ------
    EngineError : the scene was run on several ranks, which all have to take part; and
        what `gradient` raises
    """
    qoi, keys = several(qoi), several(keys)
    require_possible(result.scene, qoi, keys)
    chosen = [key(result.scene, name) for name in keys]
    result.engine.require_all(result.scene)
    base = tangent.of(result)
    if base is not None:
        return _by_tangent(base, result, qoi, chosen)
    return _by_runs(result, qoi, chosen)


def require_known(qoi: Sequence[str]) -> None:
    """Raise SceneError for a name that no run of any scene gives, before anything is
    solved.
    """
    for name in qoi:
        if why := why_unknown(name):
            raise SceneError(why)


def picked(scene: SceneBase, found: dict[str, Any], qoi: Sequence[str]) -> Array:
    """Return the named results of a run as numbers (n_qoi,).

    Raises
    ------
    SceneError : the run has no such result, or it is not a number
    """
    finite = {
        name: value
        for name, value in found.items()
        if not isinstance(value, float) or math.isfinite(value)
    }
    return np.array([number_of(finite, name, scene.origin.name) for name in qoi])


@single_blas()
def _by_tangent(
    base: Any, result: Result, qoi: tuple[str, ...], keys: list[Key]
) -> Gradient:
    scene: SceneBase = result.scene
    centre = picked(scene, result.qoi, qoi)
    slopes = []
    for one in keys:
        try:
            slopes.append(
                tangent.slope(
                    base, scene, one, lambda found: _of_state(scene, found, qoi)
                )
            )
        except UnlikeError as error:
            other = differences.slope(
                scene, one, lambda changed: _results(result, changed, qoi), centre
            )
            note = (
                f"{one.name} = {one.value:g}: {error}; its derivatives are "
                "differences of whole runs"
            )
            slopes.append(replace(other, note=note))
    return _gradient(qoi, keys, centre, slopes, base.method)


def _of_state(scene: SceneBase, found: dict[str, Any], qoi: tuple[str, ...]) -> Array:
    """Return the named results as numbers; UnlikeError for one that does not follow
    from the state alone.
    """
    for name in qoi:
        if name not in found:
            raise UnlikeError(f"{name} does not follow from the steady state alone")
    return picked(scene, found, qoi)


def _by_runs(result: Result, qoi: tuple[str, ...], keys: list[Key]) -> Gradient:
    scene: SceneBase = result.scene
    centre = picked(scene, result.qoi, qoi)
    scatters = model_of(scene).scatters
    find: Callable[..., Slope] = (
        differences.noisy_slope if scatters else differences.slope
    )
    slopes = [
        find(scene, one, lambda changed: _results(result, changed, qoi), centre)
        for one in keys
    ]
    made = _gradient(qoi, keys, centre, slopes, "differences")
    errors = np.array([one.errors for one in slopes]).reshape(len(keys), len(qoi)).T
    return (
        replace(made, standard_errors=errors)
        if scatters
        else _with_unsure(made, errors)
    )


def _results(result: Result, scene: SceneBase, qoi: tuple[str, ...]) -> Array:
    """Return the named results of another scene, run as the one of `result` was."""
    return picked(scene, run(scene, engine=result.engine.name).qoi, qoi)


def _gradient(
    qoi: tuple[str, ...],
    keys: list[Key],
    centre: Array,
    slopes: list[Slope],
    method: str,
) -> Gradient:
    return Gradient(
        qoi,
        tuple(one.name for one in keys),
        centre,
        np.array([one.value for one in keys]),
        np.array([one.values for one in slopes]).reshape(len(keys), len(qoi)).T,
        None,
        method,
        tuple(one.note for one in slopes if one.note),
    )


def _with_unsure(made: Gradient, errors: Array) -> Gradient:
    """Add a note for each derivative whose two steps do not agree."""
    weights = np.abs(made.derivatives * made.at)
    largest = weights.max(axis=1, keepdims=True) if made.keys else weights
    unsure = (errors > UNSURE * np.abs(made.derivatives)) & (weights > SMALL * largest)
    told = [
        f"d {made.qoi[i]}/d {made.keys[j]} = {made.derivatives[i, j]:.3g} is sure to "
        f"{errors[i, j]:.1g} only: "
        "runs with two steps differ"
        for i, j in np.argwhere(unsure)
    ]
    return replace(made, notes=(*made.notes, *told))
