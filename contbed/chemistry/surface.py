"""Surface mechanisms: net rates of gases at a catalyst whose coverages are in steady
state with the gas at each point.

Each reaction is one step j, or two where it runs back. Per area of the catalyst
[kmol/m2/s], with C_i of gases [kmol/m3] and of adsorbates theta_i Gamma/s_i [kmol/m2],
Gamma the density of sites and s_i the sites that one molecule takes:

    r_j = k_j prod_i C_i^o_ij
    k_j = A T^b exp(-E/(R T)) prod_i 10^(a_ij theta_i) theta_i^m_ij exp(-E_ij theta_i/(R T))
    k_j = gamma (R T/(2 pi M))^(1/2) prod_i (s_i/Gamma)^o_ij       where it sticks, gamma as k_j above

Motz and Wise put gamma/(1 - gamma/2) in place of gamma, here with gamma at most 1. A step back has
k_j/K of the step ahead, K by the thermodynamics of gases and adsorbates. Coverages follow from

    sum_j nu_ij r_j = (theta_i - theta_i0) Gamma/(s_i t),   sum_i theta_i = 1,

with theta_i0 those of the file and t = 1e7 s. They are in steady state with the gas, but for
surfaces that take longer to cover, as cold ones do with carbon. Newton's method solves for
their logarithms with a pseudo time step that grows, from the coverages of the file or those
of the call before. Derivatives to temperature and
concentrations are those of implicit functions. Atoms of gases are conserved to rounding,
as the rates are those of one equation for each gas that is made of others.

Source: Kee, Coltrin, Glarborg, Zhu 2017, Chemically Reacting Flow, 2nd ed., ch. 13;
    Motz, Wise 1960, J. Chem. Phys. 32, 1893, doi:10.1063/1.1731060.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.chemistry.equation import Equation
from contbed.chemistry.local import Local, Rate
from contbed.chemistry.rate_law import Case, RateLaw
from contbed.chemistry.thermo import R_GAS, T_STANDARD, Thermo, species_of
from contbed.errors import ConvergenceError, SceneError
from contbed.materials.pointwise import with_slopes
from contbed.scene.names import nearest
from contbed.scene.reactions import Reaction

Array = NDArray[np.float64]
KMOL = 1e3  # [mol], the unit of amounts in Cantera
READ = ("interface-Arrhenius", "sticking-Arrhenius")
# [kmol/m3] below which rates are straight lines of a concentration; gas of twice as much
# covers less than 1e-12 of a surface in DURATION
LEAST = 1e-21
DURATION = 1e7  # [s] of the gas over the surface
LEAST_COVERAGE, FIRST_COVERAGE = 1e-80, 1e-12  # the latter at the start
FIRST_STEP, LAST_STEP = 1e-9, 1e25  # of pseudo time [s]
LARGEST_FALL = 0.1  # of a coverage, its share that is left after an iteration
# change of a coverage, relative to itself and a trace, to which a pseudo time step holds
TRACE, SMALL_CHANGE, LARGE_CHANGE = 1e-3, 0.3, 0.5
# from coverages that are known, and from those of the file
ITERATIONS, MARCHED = 20, 300
EXACT = 1e-10  # relative change of all coverages at which an iteration ends
# sum of the rates of a coverage over their sizes that is rounding
ROUNDING = 1e-11


class Gas(NamedTuple):
    """What rates are made of beside coverages: the temperature (N,), ln k of the clean
    surface or ln gamma, the logarithm of the rest and its derivative to T (M, N).
    """

    T: Array
    ln_k: Array
    ln_rest: Array
    by_T: Array

    def at(self, points: NDArray[Any]) -> Gas:
        """Return those of some points."""
        return Gas(*(each[..., points] for each in self))


@dataclass(frozen=True, eq=False)
class Surface:
    """A mechanism as arrays: G gases, S adsorbates, M steps.

    thermo : of gases, then adsorbates; atoms : of each gas
    pressures : of the data of gases [Pa] (G, 1)
    sites : taken by an adsorbate (S,), start : coverages of the file (S,)
    density : of sites [kmol/m2]
    made, orders, back : counts of species by steps, orders, and made by the reaction
        ahead of a step back (M, G + S)
    ln_A, b, E : constants (M,), E [J/mol]
    ln_scale, half : of sticking steps the factor of gamma T^half, else 0 (M,)
    by_share, by_power, by_energy : a, m and E [J/mol] of coverages (M, S)
    corrected : steps with the correction of Motz and Wise (M,)
    """

    gases: tuple[str, ...]
    adsorbates: tuple[str, ...]
    thermo: tuple[Thermo, ...]
    pressures: Array
    sites: Array
    start: Array
    density: float
    made: Array
    orders: Array
    back: Array
    ln_A: Array
    b: Array
    E: Array
    ln_scale: Array
    half: Array
    by_share: Array
    by_power: Array
    by_energy: Array
    corrected: NDArray[np.bool_]

    @cached_property
    def equations(self) -> dict[str, Equation]:
        """The equation of each gas that is made of others; these have the smallest
        enthalpies of formation per atom, which elements and fuels have.
        """
        items = self.thermo[: len(self.gases)]
        atoms = [item.composition for item in items]
        elements = sorted({element for each in atoms for element in each})
        table = np.array([[each.get(e, 0.0) for e in elements] for each in atoms])
        energy = [abs(item.enthalpy(T_STANDARD)) for item in items] / table.sum(axis=1)
        first: list[int] = []
        for k in np.argsort(energy, kind="stable"):
            if np.linalg.matrix_rank(table[[*first, k]]) > len(first):
                first.append(int(k))
        found = {}
        for k, name in enumerate(self.gases):
            counts = np.linalg.lstsq(table[first].T, table[k], rcond=None)[0].round(9)
            taken = zip(first, counts, strict=True)
            made = {self.gases[i]: -float(n) for i, n in taken if n}
            if k not in first:
                found[name] = Equation({**made, name: 1.0}, False)
        return found

    def rates(self, inputs: Array, known: dict[int, Array]) -> tuple[Array, Array]:
        """Return the rates of all equations [mol/m2/s] (n, N), and their derivatives
        (n, 1 + G, N).

        Parameters
        ----------
        inputs : temperature and concentrations of the gases [mol/m3] (1 + G, N)
        known : last coverages by number of points, from which the next begin

        Raises
        ------
        ConvergenceError : no steady coverages are found
        """
        T, given = inputs[0], inputs[1:] / KMOL
        c = np.maximum(given, LEAST)
        gas = self._gas(T, c)
        theta = self._coverages(gas, known)
        r, by_T, by_theta = self._steps(gas, theta)
        G, one = len(self.gases), [self.gases.index(name) for name in self.equations]
        made = KMOL * self.made[:, one]
        by_gas = self.orders[:, :G, None] / c
        slopes = r[:, None] * np.concatenate([by_T[:, None], by_gas], axis=1)
        matrix, row = self._matrix(r, by_theta, theta)
        change = _summed(self.made[:, G:], slopes)
        change[np.arange(len(T)), row] = 0.0
        along = np.linalg.solve(matrix, change)
        by_input = _summed(made, slopes) + _summed(made, r[:, None] * by_theta) @ along
        total, by_input = made.T @ r, np.moveaxis(by_input, 0, -1)
        by_input[:, 1:] /= KMOL
        total += np.einsum("kyn,yn->kn", by_input[:, 1:], KMOL * (given - c))
        return total, by_input

    def coverages(self, T: Array, c: Array) -> Array:
        """Return the steady coverages (S, N) at temperatures (N,) and concentrations of
        the gases [mol/m3] (G, N).

        Raises
        ------
        ConvergenceError : they are not found
        """
        return self._coverages(self._gas(T, np.maximum(c / KMOL, LEAST)), {})

    def _coverages(self, gas: Gas, known: dict[int, Array]) -> Array:
        N = len(gas.T)
        start = np.maximum(self.start, FIRST_COVERAGE)
        theta, left = np.repeat(start[:, None], N, axis=1), np.ones(N, dtype=bool)
        if N in known:
            found, left = self._settled(gas, known[N], LAST_STEP)
            theta[:, ~left] = found[:, ~left]
        if left.any():
            found, lost = self._settled(gas.at(left), theta[:, left], FIRST_STEP)
            if lost.any():
                T = gas.T[left][lost][0]
                raise ConvergenceError(
                    f"no steady coverages of the surface are found at {T:.6g} K"
                )
            theta[:, left] = found
        known[N] = theta
        return theta

    def _settled(
        self, gas: Gas, theta: Array, step: float
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return coverages from those at the start, and where they are not steady."""
        N, made = len(gas.T), self.made[:, len(self.gases) :]
        start = np.maximum(self.start, FIRST_COVERAGE)[:, None]
        theta, dt, open_ = theta.copy(), np.full(N, step), np.arange(N)
        for _ in range(MARCHED if step < LAST_STEP else ITERATIONS):
            here = theta[:, open_]
            r, _, by_theta = self._steps(gas.at(open_), here)
            matrix, row = self._matrix(r, by_theta, here, dt[open_])
            residual = made.T @ r + self._held(start - here) / DURATION
            sizes = np.abs(made).T @ r + self._held(start + here) / DURATION
            noise = np.abs(residual) <= ROUNDING * sizes
            points = np.arange(len(open_))
            residual[row, points] = 1.0 - here.sum(axis=0)
            noise[row, points] = True
            change = np.linalg.solve(matrix, residual.T[..., None])[..., 0].T
            of_most = (np.abs(change) * here / (here + TRACE)).max(axis=0)
            factor = np.maximum(1.0 + change, LARGEST_FALL)
            here = np.maximum(here * factor, LEAST_COVERAGE)
            theta[:, open_] = here / here.sum(axis=0)
            size = np.abs(change).max(axis=0)
            falls = np.where(of_most < LARGE_CHANGE, 1.0, 0.2)
            grows = np.where(of_most < SMALL_CHANGE, 10.0, falls)
            steady = (dt[open_] >= LAST_STEP) & (
                (size < EXACT) | (noise.all(axis=0) & (size < 1e-3))
            )
            dt[open_] = np.minimum(dt[open_] * grows, LAST_STEP)
            open_ = open_[~steady]
            if not len(open_):
                break
        left = np.zeros(N, dtype=bool)
        left[open_] = True
        return theta, left

    def _gas(self, T: Array, c: Array) -> Gas:
        """Return what rates are made of beside coverages, at concentrations [kmol/m3]."""
        RT, G = R_GAS * T, len(self.gases)
        sites = np.log(self.density / self.sites)[:, None]
        ln_k = self.ln_A[:, None] + self.b[:, None] * np.log(T) - self.E[:, None] / RT
        ln_rest = self.ln_scale[:, None] + self.half[:, None] * np.log(T)
        ln_rest = ln_rest + self.orders @ np.concatenate([np.log(c), sites + 0.0 * T])
        by_T = self.half[:, None] / T
        if self.back.any():
            g = np.array([item.gibbs(T) for item in self.thermo]) / RT
            h = np.array([item.enthalpy(T) for item in self.thermo]) / RT
            g[:G] -= np.log(self.pressures / (RT * KMOL))
            g[G:] -= sites
            h[:G] -= 1.0
            ln_rest, by_T = ln_rest + self.back @ g, by_T - self.back @ h / T
        return Gas(T, ln_k, ln_rest, by_T)

    def _steps(self, gas: Gas, theta: Array) -> tuple[Array, Array, Array]:
        """Return the rates r of all steps [kmol/m2/s] (M, N), and the derivatives of
        ln r to the temperature (M, N) and to ln theta (M, S, N).
        """
        RT, ln_theta = R_GAS * gas.T, np.log(theta)
        share, energy = np.log(10.0) * self.by_share, self.by_energy
        barrier = energy @ theta
        ln_k = gas.ln_k + share @ theta + self.by_power @ ln_theta - barrier / RT
        by_T = (self.b[:, None] + (self.E[:, None] + barrier) / RT) / gas.T
        by_theta = theta * (share[..., None] - energy[..., None] / RT)
        by_theta += self.by_power[..., None]
        if self.corrected.any():
            gamma = self.corrected[:, None] * np.minimum(np.exp(ln_k), 1.0)
            ln_k -= np.log1p(-0.5 * gamma)
            free = np.where(gamma < 1.0, 1.0 / (1.0 - 0.5 * gamma), 1.0)
            by_T, by_theta = by_T * free, by_theta * free[:, None]
        orders = self.orders[:, len(self.gases) :]
        r = np.exp(ln_k + gas.ln_rest + orders @ ln_theta)
        return r, by_T + gas.by_T, by_theta + orders[..., None]

    def _held(self, theta: Array) -> Array:
        """Return what a surface holds of each adsorbate [kmol/m2] (S, N)."""
        return (self.density / self.sites)[:, None] * theta

    def _matrix(
        self, r: Array, by_theta: Array, theta: Array, dt: Array | float = np.inf
    ) -> tuple[Array, NDArray[np.intp]]:
        """Return minus the derivatives of what is made and held of adsorbates to
        ln theta, with a pseudo time step (N, S, S), and the row of the sum of coverages
        at each point.
        """
        made = self.made[:, len(self.gases) :]
        matrix = -_summed(made, r[:, None] * by_theta)
        every, points = np.arange(len(theta)), np.arange(theta.shape[1])
        matrix[:, every, every] += (self._held(theta) * (1.0 / dt + 1.0 / DURATION)).T
        row = theta.argmax(axis=0)
        matrix[points, row] = theta.T
        return matrix, row


def _summed(made: Array, slopes: Array) -> Array:
    """Return the sums over steps (N, k, y) of counts (M, k) times slopes (M, y, N)."""
    return np.tensordot(slopes, made, (0, 0)).transpose(1, 2, 0)


def surface_of(table: Reaction) -> Surface:
    """Return the surface mechanism that a table of a scene names.

    Raises
    ------
    SceneError : it cannot be read, or holds what is not read
    """
    file = table.mechanism_path
    path = Path(file)
    changed = path.stat().st_mtime_ns if path.is_file() else 0
    return _read(file, str(table.surface), changed)


@lru_cache(maxsize=8)
def _read(file: str, name: str, changed: int) -> Surface:
    """Read a surface phase of a mechanism whose file was `changed` at a time."""
    import cantera

    short = Path(file).name
    if name not in (known := _surfaces(file)):
        others = nearest(name, known) if known else "it has none"
        raise SceneError(f"{short} has no surface {name!r}; {others}")
    try:
        phase = cantera.Interface(file, name)
    except cantera.CanteraError as error:
        text = " ".join(line for line in str(error).split("\n") if line.strip("* "))
        raise SceneError(f"Cantera cannot read {short}: {text}") from error
    if phase.thermo_model != "ideal-surface":
        raise SceneError(
            f"{short}: {name} is a phase of the kind {phase.thermo_model}; surfaces of "
            "the kind ideal-surface are read"
        )
    gases = [
        each
        for near in phase.adjacent.values()
        if near.thermo_model == "ideal-gas"
        for each in near.species()
    ]
    adsorbates, reactions = phase.species(), phase.reactions()
    _require_read(file, reactions, {each.name for each in (*gases, *adsorbates)})
    used = {key for each in reactions for key in {**each.reactants, **each.products}}
    gases = [each for each in gases if each.name in used]
    species = [*gases, *adsorbates]
    column = {each.name: k for k, each in enumerate(species)}
    steps = [step for each in reactions for step in _steps_of(each, column, phase)]
    arrays = {key: np.array([step[key] for step in steps]) for key in steps[0]}
    found = Surface(
        tuple(each.name for each in gases),
        tuple(each.name for each in adsorbates),
        tuple(
            species_of(each.name, each, each.molecular_weight / KMOL, with_jumps=True)
            for each in species
        ),
        np.array([[each.thermo.reference_pressure] for each in gases]),
        np.array([each.size for each in adsorbates]),
        phase.coverages,
        phase.site_density,
        **arrays,
    )
    if not found.equations:
        raise SceneError(f"{short}: {name} turns no gas into another")
    return found


def _surfaces(file: str) -> list[str]:
    """Return the names of the phases of a mechanism that lie between others."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        content = YAML(typ="safe").load(Path(file))
        phases = [each for each in content["phases"] if "adjacent-phases" in each]
        return [str(each["name"]) for each in phases]
    except (OSError, YAMLError, KeyError, TypeError) as error:
        raise SceneError(f"{Path(file).name} cannot be read: {error}") from error


def _require_read(file: str, reactions: list[Any], known: set[str]) -> None:
    """Refuse reactions of a kind that is not read.

    Raises
    ------
    SceneError : with the line of the file and the equation
    """
    for reaction in reactions:
        rate, wrong = reaction.rate, ""
        others = sorted({*reaction.reactants, *reaction.products} - known)
        numbers = [v for each in _dependencies(rate).values() for v in each.values()]
        if rate.type not in READ:
            wrong = f"a rate of the kind {rate.type} is not read"
        elif rate.uses_electrochemistry:
            wrong = "charges that pass a surface are not read"
        elif others:
            wrong = f"{', '.join(others)} is neither a gas nor an adsorbate"
        elif rate.pre_exponential_factor <= 0.0:
            wrong = "a pre-exponential factor that is not positive is not read"
        elif not all(isinstance(value, float) for value in numbers):
            wrong = "energies that are polynomials of coverages are not read"
        if wrong:
            raise SceneError(f"{_place(file, reaction)}: {reaction.equation}: {wrong}")


def _dependencies(rate: Any) -> Mapping[str, Mapping[str, Any]]:
    """Return the dependencies of a rate on coverages: a, m and E by adsorbate."""
    found: Mapping[str, Mapping[str, Any]] = getattr(rate, "coverage_dependencies", {})
    return found


def _place(file: str, reaction: Any) -> str:
    """Return the file of a reaction, with its line where it is found there."""
    wanted = sorted(reaction.equation.split())
    path = Path(file)
    lines = path.read_text("utf-8").split("\n") if path.is_file() else []
    for number, line in enumerate(lines, 1):
        _, _, text = line.partition("equation:")
        if text and sorted(text.partition("#")[0].strip(" '\"").split()) == wanted:
            return f"{path.name}:{number}"
    return path.name


def _steps_of(
    reaction: Any, column: Mapping[str, int], phase: Any
) -> list[dict[str, Any]]:
    """Return the step of a reaction, and that back, by the names of the arrays."""
    rate, count = reaction.rate, len(column)
    G = count - phase.n_species
    left, right = np.zeros(count), np.zeros(count)
    for side, counts in ((left, reaction.reactants), (right, reaction.products)):
        for name, number in counts.items():
            side[column[name]] = number
    orders = left.copy()
    for name, order in reaction.orders.items():
        orders[column[name]] = order
    of_coverage = np.zeros((3, count - G))
    for name, each in _dependencies(rate).items():
        of_coverage[:, column[name] - G] = each["a"], each["m"], each["E"] / KMOL
    ln_scale, sticks = 0.0, rate.type == READ[1]
    if sticks:
        sites = np.array([each.size for each in phase.species()]) / phase.site_density
        speed = R_GAS * KMOL / (2.0 * np.pi * rate.sticking_weight)
        ln_scale = 0.5 * np.log(speed) + orders[G:] @ np.log(sites)
    ahead = {
        "made": right - left,
        "orders": orders,
        "back": np.zeros(count),
        "ln_A": np.log(rate.pre_exponential_factor),
        "b": rate.temperature_exponent,
        "E": rate.activation_energy / KMOL,
        "ln_scale": ln_scale,
        "half": 0.5 if sticks else 0.0,
        "by_share": of_coverage[0],
        "by_power": of_coverage[1],
        "by_energy": of_coverage[2],
        "corrected": sticks and rate.motz_wise_correction,
    }
    if not reaction.reversible:
        return [ahead]
    return [
        ahead,
        {**ahead, "made": left - right, "orders": right, "back": right - left},
    ]


def _rates(case: Case) -> Rate:
    surface, table = surface_of(case.table), case.table
    known: dict[int, Array] = {}

    def rates(at: Local) -> list[Any]:
        inputs = [at.T, *(at.c[name] for name in surface.gases)]
        found = with_slopes(lambda values: surface.rates(values, known), inputs)
        return [rate * (table.area or 0.0) for rate in found]

    return rates


SURFACE = RateLaw(_rates, needs=("surface", "mechanism", "area"), takes=("basis",))
