"""Particle-fluid heat transfer: Nusselt numbers h d_p / k_fluid.

`Re` is the superficial velocity of the fluid relative to the solid times d_p over the
kinematic viscosity. The powers of Re below one have an infinite slope at Re = 0, as
published: where the relative velocity can vanish and a Jacobian is needed, regularise
the velocity, not the closure.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_KUWAHARA = (
    "Kuwahara, Shirota, Nakayama 2001, Int. J. Heat Mass Transfer 44, "
    "1153-1159, doi:10.1016/S0017-9310(00)00166-6"
)
_PIVEM = (
    "Pivem, de Lemos 2012, Int. J. Heat Mass Transfer, "
    "doi:10.1016/j.ijheatmasstransfer.2011.11.047"
)
_WAKAO = (
    "Wakao, Kaguei, Funazkri 1979, Chem. Eng. Sci. 34, 325-336, "
    "doi:10.1016/0009-2509(79)85064-2"
)
_GUNN = (
    "Gunn 1978, Int. J. Heat Mass Transfer 21, 467-476, "
    "doi:10.1016/0017-9310(78)90080-7"
)
_RANZ = "Ranz, Marshall 1952, Chem. Eng. Prog. 48, 141-146"


@closure(kind="nusselt", ranges={"eps": (0.2, 0.9)}, source=_KUWAHARA)
def nusselt_kuwahara(Re: Value, Pr: Value, eps: Value) -> Value:
    """Kuwahara, Shirota and Nakayama (2001): laminar flow through arrays of square
    rods.

        Nu = 1 + 4 (1 - eps) / eps + 0.5 (1 - eps)^0.5 Re^0.6 Pr^(1/3)

    Fitted to: two-dimensional laminar simulations of periodic arrays; the side of the
        square rod takes the place of d_p
    Limits: Re -> 0: 1 + 4 (1 - eps) / eps, with infinite slope. eps -> 1: 1.
    Source: The exponent 0.6 is quoted from secondary sources; for the same equation
        printed with exponent 1 see nusselt_kuwahara_pivem.

    >>> round(float(nusselt_kuwahara(Re=100.0, Pr=0.7, eps=0.4)), 6)
    12.45019
    """
    return 1 + 4 * (1 - eps) / eps + 0.5 * (1 - eps) ** 0.5 * Re**0.6 * Pr ** (1 / 3)


@closure(kind="nusselt", ranges={"eps": (0.2, 0.9)}, source=_PIVEM)
def nusselt_kuwahara_pivem(Re: Value, Pr: Value, eps: Value) -> Value:
    """Pivem and de Lemos (2012): the Kuwahara correlation as printed there, linear in
    Re.

        Nu = 1 + 4 (1 - eps) / eps + 0.5 (1 - eps)^0.5 Re Pr^(1/3)

    Fitted to: nothing: most likely a misprint of Re^0.6, kept to repeat published
        results; see nusselt_kuwahara
    Limits: Re -> 0: 1 + 4 (1 - eps) / eps, with finite slope. eps -> 1: 1.
    Source: Eq. 20.

    >>> round(float(nusselt_kuwahara_pivem(Re=100.0, Pr=0.7, eps=0.4)), 6)
    41.388374
    """
    return 1 + 4 * (1 - eps) / eps + 0.5 * (1 - eps) ** 0.5 * Re * Pr ** (1 / 3)


@closure(kind="nusselt", ranges={"Re": (15, 8500)}, source=_WAKAO)
def nusselt_wakao_kaguei(Re: Value, Pr: Value) -> Value:
    """Wakao, Kaguei and Funazkri (1979): packed beds of spheres.

        Nu = 2 + 1.1 Re^0.6 Pr^(1/3)

    Fitted to: steady and transient data of many authors, re-evaluated with axial
        dispersion in the fluid; to be used with dispersion_wakao_kaguei_axial, without
        which the same data give a lower Nu at small Re
    Limits: Re -> 0: 2, with infinite slope. There is no dependence on eps.
    Source: Also Pivem and de Lemos 2012, eq. 19.

    >>> round(float(nusselt_wakao_kaguei(Re=100.0, Pr=0.7)), 6)
    17.479563
    """
    return 2 + 1.1 * Re**0.6 * Pr ** (1 / 3)


@closure(
    kind="nusselt",
    ranges={"Re": (0, 1e5), "eps": (0.35, 1)},
    source=_GUNN,
    bounds={"exponent_Pr": "[0, inf)"},
)
def nusselt_gunn(Re: Value, Pr: Value, eps: Value, exponent_Pr: float = 1 / 3) -> Value:
    """Gunn (1978): fixed and fluidized beds up to the single sphere.

        Nu = (7 - 10 eps + 5 eps^2) (1 + 0.7 Re^0.2 Pr^n) + (1.33 - 2.4 eps + 1.2 eps^2) Re^0.7 Pr^n

    exponent_Pr : [-] the exponent n; 1/3 by Gunn, 0.33 as others print it

    Fitted to: data on packed and fluidized beds, joined to the stochastic model of the
        bed at small Re
    Limits: Re -> 0: 7 - 10 eps + 5 eps^2, with infinite slope. Re -> 0 and eps -> 1: 2,
        the single sphere.

    >>> round(float(nusselt_gunn(Re=395.0, Pr=8.374, eps=0.49579176421443, exponent_Pr=0.33)), 6)
    76.178587
    """
    Pr_n = Pr**exponent_Pr
    stagnant = 7 - 10 * eps + 5 * eps**2
    return (
        stagnant * (1 + 0.7 * Re**0.2 * Pr_n)
        + (1.33 - 2.4 * eps + 1.2 * eps**2) * Re**0.7 * Pr_n
    )


@closure(kind="nusselt", ranges={"Re": (0, 200), "Pr": (0, 250)}, source=_RANZ)
def nusselt_ranz_marshall(Re: Value, Pr: Value) -> Value:
    """Ranz and Marshall (1952): a single sphere.

        Nu = 2 + 0.6 Re^(1/2) Pr^(1/3)

    Re : [-] Reynolds number on d_p

    Fitted to: evaporating drops
    Limits: Re -> 0: 2, conduction from a sphere, with infinite slope. In a packed bed
        it is far too low at large Re.
    Source: Range quoted from secondary sources.

    >>> round(float(nusselt_ranz_marshall(Re=100.0, Pr=0.7)), 6)
    7.327424
    """
    return 2 + 0.6 * Re**0.5 * Pr ** (1 / 3)


@closure(
    kind="nusselt",
    ranges={"Re": (0, float("inf"))},
    source="user",
    bounds={"a": "[0, inf)", "b": "[0, inf)"},
)
def nusselt_power(Re: Value, Pr: Value, a: Value, b: Value) -> Value:
    """Froessling (1938): the form of his law for drops, with free constants.

        Nu = 2 + a Re^b Pr^(1/3)

    a : [-] factor
    b : [-] exponent of Re

    Fitted to: whatever the user has fitted a and b to
    Limits: Re -> 0: 2, with infinite slope where b < 1.

    >>> round(float(nusselt_power(Re=100.0, Pr=0.7, a=1.1, b=0.6)), 6)
    17.479563
    """
    return 2 + a * Re**b * Pr ** (1 / 3)
