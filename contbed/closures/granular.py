"""Granular flow, where particles meet: radial distribution at contact, pressure of
collisions.

    theta [m2/s2] granular temperature, a third of the mean square of the fluctuating velocity
    eps_s, eps_max [-] fraction of the particles, at most
    e [-] restitution         g0 [-] radial distribution at contact

Pressure of collisions is given without rho_s theta.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_SINCLAIR = "Sinclair, Jackson 1989, AIChE J. 35, 1473-1486, doi:10.1002/aic.690350908"
_LUN_SAVAGE = "Lun, Savage 1986, Acta Mech. 63, 15-44, doi:10.1007/BF01182538"
_CARNAHAN = "Carnahan, Starling 1969, J. Chem. Phys. 51, 635-636, doi:10.1063/1.1672048"
_MA = "Ma, Ahmadi 1986, J. Chem. Phys. 84, 3449, doi:10.1063/1.450229"
_LUN = (
    "Lun, Savage, Jeffrey, Chepurniy 1984, J. Fluid Mech. 140, 223-256, "
    "doi:10.1017/S0022112084000586"
)
_SYAMLAL = (
    "Syamlal, Rogers, O'Brien 1993, MFIX documentation: theory guide, "
    "DOE/METC-94/1004, doi:10.2172/10145548"
)
_DENSE = {"eps_s": (0.0, 0.63), "e": (0.0, 1.0)}


@closure(kind="radial_distribution", ranges={"eps_s": (0, 0.63)}, source=_SINCLAIR)
def g0_sinclair_jackson(eps_s: Value, eps_max: Value) -> Value:
    """Sinclair and Jackson (1989): radial distribution, infinite at packing.

    g0 = 1/(1 - (eps_s/eps_max)^(1/3))

    Fitted to: geometry: the mean gap of particles over their diameter
    Limits: eps_s -> 0: 1. eps_s -> eps_max: infinite.

    >>> round(float(g0_sinclair_jackson(eps_s=0.3, eps_max=0.6)), 5)
    4.84732
    """
    return 1.0 / (1.0 - (eps_s / eps_max) ** (1.0 / 3.0))


@closure(
    kind="radial_distribution",
    ranges={"eps_s": (0, 0.63)},
    source=_LUN_SAVAGE,
)
def g0_lun_savage(eps_s: Value, eps_max: Value) -> Value:
    """Lun and Savage (1986): radial distribution, infinite at packing.

    g0 = (1 - eps_s/eps_max)^(-2.5 eps_max)

    Fitted to: simulated hard spheres, and divergence at packing
    Limits: eps_s -> 0: 1. eps_s -> eps_max: infinite.

    >>> round(float(g0_lun_savage(eps_s=0.3, eps_max=0.6)), 5)
    2.82843
    """
    return (1.0 - eps_s / eps_max) ** (-2.5 * eps_max)


@closure(kind="radial_distribution", ranges={"eps_s": (0, 0.5)}, source=_CARNAHAN)
def g0_carnahan_starling(eps_s: Value) -> Value:
    """Carnahan and Starling (1969): radial distribution of the fluid of hard spheres,
    which knows no packing.

    g0 = 1/(1 - eps_s) + 3 eps_s/(2 (1 - eps_s)^2) + eps_s^2/(2 (1 - eps_s)^3)

    Fitted to: virial coefficients of the hard-sphere fluid
    Limits: eps_s -> 0: 1 + 2.5 eps_s.

    >>> round(float(g0_carnahan_starling(eps_s=0.3)), 5)
    2.47813
    """
    loose = 1.0 - eps_s
    return 1.0 / loose + 1.5 * eps_s / loose**2 + 0.5 * eps_s**2 / loose**3


@closure(kind="radial_distribution", ranges={"eps_s": (0, 0.63)}, source=_MA)
def g0_ma_ahmadi(eps_s: Value, eps_max: Value) -> Value:
    """Ma and Ahmadi (1986): radial distribution, infinite at packing.

    g0 = (1 + 2.5 eps_s + 4.5904 eps_s^2 + 4.515439
    eps_s^3)/(1 - (eps_s/eps_max)^3)^0.67802

    Fitted to: simulated hard spheres
    Limits: eps_s -> 0: 1. eps_s -> eps_max: infinite.

    >>> round(float(g0_ma_ahmadi(eps_s=0.3, eps_max=0.6)), 5)
    2.50159
    """
    series = 1.0 + 2.5 * eps_s + 4.5904 * eps_s**2 + 4.515439 * eps_s**3
    return series / (1.0 - (eps_s / eps_max) ** 3) ** 0.67802


@closure(kind="granular_pressure", ranges=_DENSE, source=_LUN)
def granular_pressure_lun(eps_s: Value, g0: Value, e: Value) -> Value:
    """Lun et al. (1984): pressure over rho_s theta.

    p = rho_s theta eps_s (1 + 2 (1 + e) eps_s g0)

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: eps_s -> 0: eps_s, the ideal gas of particles.

    >>> round(float(granular_pressure_lun(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    2.001409
    """
    return eps_s * (1.0 + 2.0 * (1.0 + e) * eps_s * g0)


@closure(kind="granular_pressure", ranges=_DENSE, source=_LUN)
def granular_pressure_dilute(eps_s: Value, g0: Value, e: Value) -> Value:
    """Lun et al. (1984): pressure over rho_s theta in the dilute limit, without
    collisions.

        p = rho_s theta eps_s

    g0 : [-] radial distribution at contact, without effect
    e : [-] restitution of two particles, without effect

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: the ideal gas of particles

    >>> float(granular_pressure_dilute(eps_s=0.3, g0=1.0, e=0.95))
    0.3
    """
    return eps_s + 0.0 * (g0 + e)


@closure(kind="granular_pressure", ranges=_DENSE, source=_SYAMLAL)
def granular_pressure_syamlal(eps_s: Value, g0: Value, e: Value) -> Value:
    """Syamlal et al. (1993): pressure over rho_s theta, collisions alone.

    p = 2 rho_s theta (1 + e) eps_s^2 g0

    Fitted to: kinetic theory, without the kinetic part
    Limits: eps_s -> 0: 2 (1 + e) eps_s^2.

    >>> round(float(granular_pressure_syamlal(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    1.701409
    """
    return 2.0 * (1.0 + e) * eps_s**2 * g0
