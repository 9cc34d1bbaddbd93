"""Heat from a cylinder to the gas that flows across it: Nusselt numbers h D/k on the
diameter of the cylinder.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_CHURCHILL = (
    "Churchill, Bernstein 1977, J. Heat Transfer 99, 300-306, doi:10.1115/1.3450685"
)
_ZHOU = (
    "Zhou, Hou, Yu 2011, in: Heat Transfer, InTech, Rijeka, ch. 17 (after Dittus "
    "and Boelter 1930)"
)


@closure(
    kind="nusselt_cylinder",
    ranges={"Re": (0.3, 1e7), "Pr": (0.5, 1e3)},
    source=_CHURCHILL,
)
def nusselt_cylinder_churchill_bernstein(Re: Value, Pr: Value) -> Value:
    """Churchill and Bernstein (1977): mean of a cylinder across a free stream.

        Nu = 0.3 + 0.62 Re^(1/2) Pr^(1/3)/(1 + (0.4/Pr)^(2/3))^(1/4) (1 + (Re/282000)^(5/8))^(4/5)

    Fitted to: measurements of many authors in gases and liquids, Re Pr > 0.2, for
        0.7 < Pr mostly
    Limits: Re -> 0: 0.3, with infinite slope.
    Source: Particles beside the cylinder, which stir and hold the gas, are not in it.

    >>> round(float(nusselt_cylinder_churchill_bernstein(Re=1000.0, Pr=0.7)), 6)
    15.929612
    """
    laminar = 0.62 * Re**0.5 * Pr ** (1 / 3) / (1.0 + (0.4 / Pr) ** (2 / 3)) ** 0.25
    return 0.3 + laminar * (1.0 + (Re / 282000.0) ** 0.625) ** 0.8


@closure(
    kind="nusselt_cylinder",
    ranges={"Re": (1e4, 1.2e5), "Pr": (0.7, 120.0)},
    source=_ZHOU,
)
def nusselt_cylinder_dittus_boelter(Re: Value, Pr: Value) -> Value:
    """Dittus and Boelter (1930): pipes, as Zhou, Hou and Yu (2011) take it for walls
    and tubes in a bed.

        Nu = 0.023 Re^0.8 Pr^0.4

    Fitted to: turbulent flow inside of pipes, which a tube in a bed is not; kept to
        repeat published results
    Limits: Re -> 0: 0, with infinite slope.

    >>> round(float(nusselt_cylinder_dittus_boelter(Re=20000.0, Pr=0.7)), 6)
    55.028927
    """
    return 0.023 * Re**0.8 * Pr**0.4
