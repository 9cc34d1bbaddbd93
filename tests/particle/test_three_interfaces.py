"""Hematite pellet with three interfaces: published-form pellet in constant gas,
balances, guards, derivatives.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from pytest import approx
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from contbed.chemistry.laws import three_interfaces as three
from contbed.fem.ad.dual import Dual
from tests.particle.tables import rows

R_GAS = 8.31446261815324
IRON = 2 * 0.9665 * 3528 / 0.15969  # [mol/m3], of the table
FILM = 0.15  # [m/s], of the table
KEYS = ("T_K", "x_H2", "p_Pa", "d_m")
CASES = [
    (key, list(group))
    for key, group in groupby(
        rows("pellet_three_interfaces.csv"), lambda r: [r[k] for k in KEYS]
    )
]


def surroundings(T, x, p):
    c = p / (R_GAS * T)
    return three.Gas(x * c, (1 - x) * c, FILM), three.TAKAHASHI["H2"].constants(T)


def pellet_rates(X, R, gas, at, guard=three.GUARD):
    """Reducing gas taken at each interface per area of the pellet [mol/m2/s]."""
    w = three.interface_rates(X, R, gas, at, guard)
    return tuple(rate * x * x for rate, x in zip(w, X, strict=True))


def oxygen_removed(X):
    """Share of the oxygen of Fe2O3 that is gone."""
    left = sum(s * x**3 for s, x in zip(three.GAS_PER_IRON, X, strict=True))
    return 1.0 - left / sum(three.GAS_PER_IRON)


def pellet(T, x, p, d, guard):
    """Time [s] as a function of the share of oxygen removed, integrated from one end
    of a core to the next.
    """
    gas, at = surroundings(T, x, p)

    def speeds(t, X):
        w = three.interface_rates(tuple(X), d / 2, gas, at, guard)
        return [
            -v / (s * IRON * d / 2) if x > 0 else 0.0
            for v, s, x in zip(w, three.GAS_PER_IRON, X, strict=True)
        ]

    X, t, parts = np.ones(3), 0.0, []
    for gone in range(3):

        def end(t, X, gone=gone):
            return X[gone] - 1e-8

        end.terminal = True
        part = solve_ivp(
            speeds,
            (t, t + 1e5),
            X,
            method="DOP853",
            rtol=1e-10,
            atol=1e-12,
            events=[end],
            dense_output=True,
        )
        parts.append(part)
        t, X = float(part.t[-1]), part.y[:, -1].copy()
        X[gone] = 0.0

    def at_reduction(share):
        if share >= 1.0:
            return t

        def missing(time):
            part = next(part for part in parts if time <= part.t[-1])
            return oxygen_removed(tuple(np.maximum(part.sol(time), 0.0))) - share

        return brentq(missing, 0.0, t, xtol=1e-10)

    return at_reduction


@pytest.mark.parametrize(("key", "group"), CASES)
def test_pellet_in_constant_gas(key, group):
    time = pellet(*key, guard=0.0)
    for row in group:
        # the table starts at a radius just below 1: times are 1e-6 s apart at first,
        # and 4e-7 at the very end
        assert time(row["reduction"]) == approx(row["t_s"], rel=1e-6, abs=3e-6)


def test_guard_changes_little():
    key, group = CASES[0]
    time = pellet(*key, guard=three.GUARD)
    for row in group[:-1]:
        assert time(row["reduction"]) == approx(
            row["t_s"], rel=5e-4, abs=0.1
        )  # the later stages begin some 0.05 s later


def test_elimination_solves_the_system_of_resistances():
    T, x, p, R = 1100.0, 0.7, 1.3e5, 0.006
    gas, at = surroundings(T, x, p)
    X = (0.3, 0.6, 0.9)
    v = pellet_rates(X, R, gas, at, guard=0.0)
    c3 = gas.reducing - sum(v) * ((1 / X[2] - 1) * R / at.D[2] + 1 / FILM)
    c2 = c3 - (v[0] + v[1]) * (1 / X[1] - 1 / X[2]) * R / at.D[1]
    c1 = c2 - v[0] * (1 / X[0] - 1 / X[1]) * R / at.D[0]
    for vi, xi, ci, k, K in zip(v, X, (c1, c2, c3), at.k, at.K, strict=True):
        e = (gas.reducing + gas.oxidised) / (1 + K)
        assert vi == approx(xi**2 * k * (1 + 1 / K) * (ci - e), rel=1e-10)


def test_gas_in_equilibrium_with_a_stage_does_nothing():
    T = 1100.0
    at = three.TAKAHASHI["CO"].constants(T)
    c = 10.0
    gas = three.Gas(c / (1 + at.K[2]), c * at.K[2] / (1 + at.K[2]), FILM)
    v = three.interface_rates((0.0, 0.0, 0.5), 0.005, gas, at, guard=0.0)
    assert abs(v[2]) < 1e-12 * c


def test_no_interface_overtakes_below_the_triple_point():
    T = 780.0  # K_2 < K_3: magnetite turns to iron, wustite is not stable
    gas, at = surroundings(T, 0.98, 101325.0)

    def speeds(t, X):
        w = three.interface_rates(tuple(X), 0.006, gas, at)
        return [
            -v / (s * IRON * 0.006) for v, s in zip(w, three.GAS_PER_IRON, strict=True)
        ]

    X = solve_ivp(
        speeds, (0, 400.0), np.ones(3), method="LSODA", rtol=1e-8, atol=1e-10
    ).y
    assert np.all(X[0] <= X[1] + 1e-6) and np.all(X[1] <= X[2] + 1e-6)
    assert X[2, -1] < 0.999


def test_nothing_goes_back_without_product():
    at = three.TAKAHASHI["H2"].constants(1100.0)
    gas = three.Gas(0.0, 10.0, FILM)  # steam
    assert pellet_rates((1.0, 1.0, 1.0), 0.005, gas, at) == approx(
        (0.0, 0.0, 0.0), abs=1e-12
    )
    assert pellet_rates((0.5, 0.7, 0.9), 0.005, gas, at)[2] < 0.0


def test_a_core_that_is_gone_takes_nothing():
    gas, at = surroundings(1173.15, 0.98, 184411.0)
    v = pellet_rates((0.0, 0.0, 0.4), 0.0075, gas, at)
    assert v[0] == 0.0 and v[1] == 0.0 and v[2] > 0.0
    assert np.isfinite(pellet_rates((0.0, 0.0, 0.0), 0.0075, gas, at)).all()


def test_derivatives_by_dual_numbers():
    gas, at = surroundings(1000.0, 0.8, 1e5)
    X = [0.4, 0.7, 0.95]
    one = np.ones(1)
    numbers = tuple(Dual(np.array([x]), {k: one}) for k, x in enumerate(X))
    c = Dual(np.array([gas.reducing]), {"c": one})
    found = pellet_rates(numbers, 0.006, three.Gas(c, gas.oxidised, FILM), at)
    step = 1e-5

    def rates(X, reducing):
        return pellet_rates(
            tuple(X), 0.006, three.Gas(reducing, gas.oxidised, FILM), at
        )

    for k in range(3):
        up, down = ([x + s * (j == k) for j, x in enumerate(X)] for s in (step, -step))
        wanted = [
            (a - b) / (2 * step)
            for a, b in zip(
                rates(up, gas.reducing), rates(down, gas.reducing), strict=True
            )
        ]
        # differences of order step^2; a rate that does not depend on a radius has no
        # such slope
        assert [float(v.tangents[k][0]) for v in found] == approx(
            wanted, rel=1e-6, abs=1e-7
        )
    wanted = [
        (a - b) / (2 * step)
        for a, b in zip(
            rates(X, gas.reducing + step), rates(X, gas.reducing - step), strict=True
        )
    ]
    assert [float(v.tangents["c"][0]) for v in found] == approx(wanted, rel=1e-6)


def test_all_pellets_at_once():
    T = np.array([900.0, 1173.15])
    c = 1e5 / (R_GAS * T)
    gas = three.Gas(0.9 * c, 0.1 * c, FILM)
    X = tuple(np.array(x) for x in ((0.2, 0.5), (0.5, 0.6), (0.8, 0.9)))
    both = np.array(pellet_rates(X, 0.006, gas, three.TAKAHASHI["CO"].constants(T)))
    for k in range(2):
        at = three.TAKAHASHI["CO"].constants(T[k])
        single = pellet_rates(
            tuple(x[k] for x in X), 0.006, three.Gas(0.9 * c[k], 0.1 * c[k], FILM), at
        )
        assert both[:, k] == approx(np.array(single), rel=1e-13)
