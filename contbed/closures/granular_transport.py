"""Granular flow, transport by the kinetic theory: viscosities, conductivity,
dissipation, and what guards them.

    theta [m2/s2] granular temperature, a third of the mean square of the fluctuating velocity
    eps_s, eps_max [-] fraction of the particles, at most
    e [-] restitution         g0 [-] radial distribution at contact

Given without their powers of theta, density and diameter. A viscosity or conductivity
is the sum of a collisional and a kinetic part; `kinetic` is the share of the kinetic
part that the guards `share_drag` and `share_free_path` leave.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_LUN = (
    "Lun, Savage, Jeffrey, Chepurniy 1984, J. Fluid Mech. 140, 223-256, "
    "doi:10.1017/S0022112084000586"
)
_SYAMLAL = (
    "Syamlal, Rogers, O'Brien 1993, MFIX documentation: theory guide, "
    "DOE/METC-94/1004, doi:10.2172/10145548"
)
_GIDASPOW = "Gidaspow 1994, Multiphase Flow and Fluidization, Academic Press, chapter 9"
_KOCH = "Koch, Sangani 1999, J. Fluid Mech. 400, 229-263, doi:10.1017/S0022112099006485"
_DENSE = {"eps_s": (0.0, 0.63), "e": (0.0, 1.0)}
_PI = 3.141592653589793


@closure(kind="granular_viscosity", ranges=_DENSE, source=_GIDASPOW)
def granular_viscosity_gidaspow(
    eps_s: Value, g0: Value, e: Value, kinetic: Value = 1.0
) -> Value:
    """Gidaspow (1994): shear viscosity over rho_s d_p sqrt(theta).

    mu = rho_s d_p sqrt(theta) [4/5 eps_s^2 g0 (1 + e)/sqrt(pi)
                                + 10 sqrt(pi)/(96 (1 + e) g0) (1 + 4/5 (1 + e) g0 eps_s)^2]

    the first term collisional, the second kinetic. Print often loses an eps_s of the
    first, or divides the second by eps_s; both contradict the kinetic theory.

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: eps_s -> 0: 10 sqrt(pi)/(96 (1 + e)), not zero: dilute flows need the
        guards.

    >>> round(float(granular_viscosity_gidaspow(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    0.592645
    """
    collisional = 0.8 * eps_s**2 * g0 * (1.0 + e) / _PI**0.5
    dilute = 10.0 * _PI**0.5 / (96.0 * (1.0 + e) * g0)
    return collisional + kinetic * dilute * (1.0 + 0.8 * (1.0 + e) * g0 * eps_s) ** 2


@closure(kind="granular_viscosity", ranges=_DENSE, source=_SYAMLAL)
def granular_viscosity_syamlal(
    eps_s: Value, g0: Value, e: Value, kinetic: Value = 1.0
) -> Value:
    """Syamlal et al. (1993): shear viscosity over rho_s d_p sqrt(theta).

    mu = rho_s d_p sqrt(theta) [4/5 eps_s^2 g0 (1 + e)/sqrt(pi)
                                + eps_s sqrt(pi)/(6 (3 - e)) (1 + 2/5 (1 + e) (3 e - 1) eps_s g0)]

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: eps_s -> 0: sqrt(pi) eps_s/(6 (3 - e)).

    >>> round(float(granular_viscosity_syamlal(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    0.517913
    """
    collisional = 0.8 * eps_s**2 * g0 * (1.0 + e) / _PI**0.5
    rest = 1.0 + 0.4 * (1.0 + e) * (3.0 * e - 1.0) * eps_s * g0
    return collisional + kinetic * eps_s * _PI**0.5 / (6.0 * (3.0 - e)) * rest


@closure(kind="granular_bulk_viscosity", ranges=_DENSE, source=_LUN)
def granular_bulk_lun(eps_s: Value, g0: Value, e: Value) -> Value:
    """Lun et al. (1984): bulk viscosity over rho_s d_p sqrt(theta).

    bulk = 4/3 rho_s d_p sqrt(theta) eps_s^2 g0 (1 + e)/sqrt(pi)

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: eps_s -> 0: as eps_s^2.

    >>> round(float(granular_bulk_lun(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    0.639945
    """
    return 4.0 / 3.0 * eps_s**2 * g0 * (1.0 + e) / _PI**0.5


@closure(kind="granular_conductivity", ranges=_DENSE, source=_SYAMLAL)
def granular_conductivity_syamlal(
    eps_s: Value, g0: Value, e: Value, kinetic: Value = 1.0
) -> Value:
    """Syamlal et al. (1993): conductivity of granular energy over rho_s d_p
    sqrt(theta).

    k = rho_s d_p sqrt(theta) 15 sqrt(pi) eps_s/(4 (41 - 33 eta))
        [1 + 12/5 eta^2 (4 eta - 3) eps_s g0 + 16/(15 pi) (41 - 33 eta) eta eps_s g0],  eta = (1 + e)/2

    the last term collisional.

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: eps_s -> 0: 15 sqrt(pi) eps_s/(4 (41 - 33 eta)).

    >>> round(float(granular_conductivity_syamlal(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    1.860549
    """
    eta = 0.5 * (1.0 + e)
    rest = 1.0 + 2.4 * eta**2 * (4.0 * eta - 3.0) * eps_s * g0
    return (
        kinetic * 3.75 * _PI**0.5 * eps_s / (41.0 - 33.0 * eta) * rest
        + 4.0 * eta * eps_s**2 * g0 / _PI**0.5
    )


@closure(kind="granular_conductivity", ranges=_DENSE, source=_GIDASPOW)
def granular_conductivity_gidaspow(
    eps_s: Value, g0: Value, e: Value, kinetic: Value = 1.0
) -> Value:
    """Gidaspow (1994): conductivity of granular energy over rho_s d_p sqrt(theta).

    k = rho_s d_p sqrt(theta) [2 eps_s^2 g0 (1 + e)/sqrt(pi)
                               + 75 sqrt(pi)/(192 (1 + e) g0) (1 + 6/5 (1 + e) g0 eps_s)^2]

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: eps_s -> 0: 75 sqrt(pi)/(192 (1 + e)), not zero: dilute flows need the
        guards.

    >>> round(float(granular_conductivity_gidaspow(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    2.379826
    """
    collisional = 2.0 * eps_s**2 * g0 * (1.0 + e) / _PI**0.5
    dilute = 75.0 * _PI**0.5 / (192.0 * (1.0 + e) * g0)
    return collisional + kinetic * dilute * (1.0 + 1.2 * (1.0 + e) * g0 * eps_s) ** 2


@closure(kind="granular_dissipation", ranges=_DENSE, source=_LUN)
def granular_dissipation_lun(eps_s: Value, g0: Value, e: Value) -> Value:
    """Lun et al. (1984): dissipation by inelastic collisions, times d_p/(rho_s
    theta^(3/2)).

    gamma = 12 (1 - e^2) eps_s^2 g0 rho_s theta^(3/2)/(d_p sqrt(pi))

    Fitted to: kinetic theory of slightly inelastic spheres
    Limits: e = 1: none.

    >>> round(float(granular_dissipation_lun(eps_s=0.3, g0=4.84732, e=0.95)), 6)
    0.287975
    """
    return 12.0 * (1.0 - e**2) * eps_s**2 * g0 / _PI**0.5


@closure(kind="granular_production", ranges={"eps_s": (0.0, 0.63)}, source=_KOCH)
def granular_production_koch(eps_s: Value, g0: Value) -> Value:
    """Koch (1990), Koch and Sangani (1999): fluctuations that the slip between gas and
    particles gives to particles.

    S = 81 eps_s mu^2 slip^2/(g0 d_p^3 rho_s sqrt(pi theta)) [W/m3], times d_p^3 rho_s
    sqrt(theta)/(mu^2 slip^2)

    Fitted to: kinetic theory of spheres with Stokes' drag, particles heavy enough to
        keep their velocity between collisions; the drag factor of dense suspensions is
        left at its dilute limit 1
    Limits: eps_s -> 0: 81 eps_s/sqrt(pi), the square of 18 over 4.
    Source: As used for risers in secondary sources.

    >>> round(float(granular_production_koch(eps_s=0.03, g0=1.08)), 6)
    1.269427
    """
    return 81.0 * eps_s / (g0 * _PI**0.5)


def share_drag(
    K: Value,
    theta: Value,
    eps_s: Value,
    g0: Value,
    rho_s: Value,
    d_p: Value,
    dilute: Value,
    factor: float = 2.0,
) -> Value:
    """Agrawal et al. (2001): share of the kinetic part that drag leaves, since gas
    stops particles between collisions.

    share = 1/(1 + factor K mu/(rho_s^2 eps_s g0 theta)),  mu = dilute rho_s d_p
    sqrt(theta)

    Parameters
    ----------
    K : [kg/m3/s] drag coefficient over eps_s
    theta : [m2/s2] granular temperature
    eps_s : [-] fraction of the particles
    g0 : [-] radial distribution at contact
    rho_s : [kg/m3] density of the particles
    d_p : [m] particle diameter
    dilute : [-] dilute value over rho_s d_p sqrt(theta)
    factor : [-] 2 for viscosity, 1.2 for conductivity

    Returns
    -------
    [-] share of the kinetic viscosity or conductivity

    Fitted to
    ---------
    kinetic theory of particles in a viscous gas

    Limits
    ------
    K = 0: 1. theta -> 0: 0.

    Example
    -------
    >>> round(float(share_drag(K=60.0, theta=0.1, eps_s=0.01, g0=1.3, rho_s=2550.0, d_p=150e-6, dilute=0.0923)), 6)
    0.999842

    Source
    ------
    Agrawal, Loezos, Syamlal, Sundaresan 2001, J. Fluid Mech. 445, 151-185, doi:10.1017/S0022112001005663.
    """
    return 1.0 / (
        1.0
        + factor
        * K
        * dilute
        * d_p
        / (rho_s * (eps_s + 1e-12) * g0 * theta**0.5 + 1e-30)
    )


def share_free_path(eps_s: Value, g0: Value, d_p: Value, length: Value) -> Value:
    """Share of the kinetic part where the free path would exceed a length of the flow.

    share = 1/(1 + Kn),  Kn = d_p/(6 sqrt(2) eps_s g0 length)

    Kinetic viscosity does not vanish with eps_s, so that sheared dilute flows heat
    without bound; a particle cannot carry momentum further than the flow is wide.

    Parameters
    ----------
    eps_s : [-] fraction of the particles
    g0 : [-] radial distribution at contact
    d_p : [m] particle diameter
    length : [m] longest free path

    Returns
    -------
    [-] share of the kinetic viscosity or conductivity

    Fitted to
    ---------
    mean free path of hard spheres

    Limits
    ------
    eps_s -> 0: 0. Dense: 1.

    Example
    -------
    >>> round(float(share_free_path(eps_s=0.01, g0=1.3, d_p=150e-6, length=0.01)), 6)
    0.880296

    """
    return 1.0 / (1.0 + d_p / (6.0 * 2.0**0.5 * (eps_s + 1e-12) * g0 * length))
