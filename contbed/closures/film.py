"""Films and dispersion of species in packed beds: Sherwood numbers and axial
dispersion coefficients.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_FUNAZKRI = (
    "Wakao, Funazkri 1978, Chem. Eng. Sci. 33, 1375-1384, "
    "doi:10.1016/0009-2509(78)85120-3"
)
_EDWARDS = (
    "Edwards, Richardson 1968, Chem. Eng. Sci. 23, 109-123, "
    "doi:10.1016/0009-2509(68)87056-3"
)
_LANGER = "Langer, Roethe, Roethe, Gelbin 1978, Int. J. Heat Mass Transfer 21, 751-759"
_RANZ = "Ranz, Marshall 1952, Chem. Eng. Prog. 48, 141-146"


@closure(kind="sherwood", ranges={"Re": (3, 1e4)}, source=_FUNAZKRI)
def sherwood_wakao_funazkri(Re: Value, Sc: Value) -> Value:
    """Wakao and Funazkri (1978): packed beds of spheres.

        Sh = 2 + 1.1 Re^0.6 Sc^(1/3)

    Fitted to: data of many authors, re-evaluated with axial dispersion of the species
    Limits: Re -> 0: 2, with infinite slope.

    >>> round(float(sherwood_wakao_funazkri(Re=100.0, Sc=1.0)), 6)
    19.433825
    """
    return 2 + 1.1 * Re**0.6 * Sc ** (1 / 3)


@closure(kind="sherwood", ranges={"Re": (0, 200)}, source=_RANZ)
def sherwood_ranz_marshall(Re: Value, Sc: Value) -> Value:
    """Ranz and Marshall (1952): one sphere in a stream.

        Sh = 2 + 0.6 Re^0.5 Sc^(1/3)

    Fitted to: evaporating drops; a lower bound for particles of a bed
    Limits: Re -> 0: 2, with infinite slope.

    >>> round(float(sherwood_ranz_marshall(Re=100.0, Sc=1.0)), 6)
    8.0
    """
    return 2 + 0.6 * Re**0.5 * Sc ** (1 / 3)


@closure(kind="mass_dispersion", ranges={"D_gas": (0, 1e-2)}, source=_EDWARDS)
def mass_dispersion_edwards_richardson(v: Value, d_p: Value, D_gas: Value) -> Value:
    """Edwards and Richardson (1968): axial dispersion of a gas in a packed bed.

        D = 0.73 D_gas + 0.5 v d_p/(1 + 9.7 D_gas/(v d_p))

    Result: coefficient on the velocity between the particles; the flux per area of bed
        carries the porosity
    Fitted to: gases through beds of spheres, 0.008 < Re < 50
    Limits: v -> 0: 0.73 D_gas. v -> infinite: 0.5 v d_p, a Peclet number of 2.
    Source: Quoted from secondary sources.

    >>> round(mass_dispersion_edwards_richardson(v=1.0, d_p=2e-3, D_gas=2e-5), 9)
    0.000926177
    """
    vd = v * d_p
    return 0.73 * D_gas + 0.5 * vd * vd / (vd + 9.7 * D_gas)


@closure(
    kind="mass_dispersion",
    ranges={"v": (0, 1e3)},
    source=_LANGER,
    bounds={"Pe_p": "(0, inf)"},
)
def mass_dispersion_peclet(v: Value, d_p: Value, Pe_p: Value = 2.0) -> Value:
    """Langer, Roethe, Roethe and Gelbin (1978): axial dispersion of constant Peclet
    number on the particle.

        D = v d_p/Pe_p

    Pe_p : [-] Peclet number v d_p/D

    Result: coefficient on the velocity between the particles; the flux per area of bed
        carries the porosity
    Fitted to: gases in beds of spheres at high Reynolds numbers, where 2 is the limit
        of all correlations
    Limits: Re -> infinite: as it is. The flux of dispersion is that of the mass flux,
        whatever the density.

    >>> mass_dispersion_peclet(v=1.0, d_p=2e-3)
    0.001
    """
    return v * d_p / Pe_p
