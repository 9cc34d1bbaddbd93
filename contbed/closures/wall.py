"""Heat transfer between a packed bed and the wall of its tube [W/m2/K], on the
temperature jump of a plug-flow model.

A wall coefficient belongs to the transverse conductivity that it was fitted with: take
both from one school.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_LI = (
    "Li, Finlayson 1977, Chem. Eng. Sci. 32, 1055-1066, "
    "doi:10.1016/0009-2509(77)80143-7"
)
_MARTIN = (
    "Martin, Nilles 1993, Chem. Ing. Tech. 65, 1468-1477, doi:10.1002/cite.330651206"
)


@closure(
    kind="wall",
    ranges={"Re": (20, 7600), "Pr": (0.6, 0.8), "d_p/D_bed": (0.05, 0.3)},
    source=_LI,
)
def wall_li_finlayson(
    Re: Value, Pr: Value, k_fluid: Value, d_p: Value, D_bed: Value
) -> Value:
    """Li and Finlayson (1977): spheres in a tube, gas.

        h d_p / k_fluid = 0.17 Re^0.79 (Pr / 0.7)^(1/3)

    D_bed : [m] diameter of the bed; enters the range only

    Fitted to: air; data of several authors, chosen to be free of length effects. The
        factor in Pr is the usual extension and equals one for the data
    Limits: Re -> 0: 0, with infinite slope. Stagnant conduction to the wall is missing:
        below the range it is far too low.
    Source: Constants and range quoted from secondary sources.

    >>> round(float(wall_li_finlayson(Re=200.0, Pr=0.7, k_fluid=0.03, d_p=0.005, D_bed=0.05)), 6)
    67.052329
    """
    return 0.17 * Re**0.79 * (Pr / 0.7) ** (1 / 3) * k_fluid / d_p


@closure(
    kind="wall",
    ranges={"Re": (50, 20000), "d_p/D_bed": (0.02, 0.8)},
    source=_MARTIN,
)
def wall_martin_nilles(
    Re: Value, Pr: Value, k_fluid: Value, k_stagnant: Value, d_p: Value, D_bed: Value
) -> Value:
    """Martin and Nilles (1993): packed tubes, with stagnant conduction to the wall.

        h d_p / k_fluid = (1.3 + 5 d_p / D_bed) k_stagnant / k_fluid + 0.19 Re^0.75 Pr^(1/3)

    Fitted to: heat transfer in packed tubes of many authors, with k_stagnant of
        conductivity_zehner_bauer_schluender and the transverse dispersion of
        dispersion_vdi_transverse
    Limits: Re -> 0: (1.3 + 5 d_p / D_bed) k_stagnant / d_p, with infinite slope.
    Source: Constants and range quoted from secondary sources.

    >>> h = wall_martin_nilles(Re=200.0, Pr=0.7, k_fluid=0.03, k_stagnant=0.2, d_p=0.005, D_bed=0.05)
    >>> round(float(h), 6)
    125.832353
    """
    return (
        (1.3 + 5 * d_p / D_bed) * k_stagnant + 0.19 * Re**0.75 * Pr ** (1 / 3) * k_fluid
    ) / d_p
