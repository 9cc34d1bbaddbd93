"""Stabilisation of convection by streamline upwinding (SUPG)."""

from __future__ import annotations

from typing import Any


def tau(
    c_flux: Any, conductivity: Any, exchange: Any, capacity: float, h: Any, degree: int
) -> Any:
    """Return the stabilisation parameter of SUPG for cells of size `h` [m] and elements
    of `degree`.

    tau / capacity = ((2 C u / h)^2 + 9 (4 k / h^2)^2 + a^2)^(-1/2), with h divided by
    the degree, `c_flux` = C u [W/m2/K], k the `conductivity` [W/m/K] and a the
    `exchange` [W/m3/K]. Convection, conduction and exchange are the three limits.
    Shakib, Hughes & Johan 1991, doi:10.1016/0045-7825(91)90041-4.
    """
    h = h / degree
    return (
        capacity
        / (
            (2.0 * c_flux / h) ** 2
            + 9.0 * (4.0 * conductivity / h**2) ** 2
            + exchange**2
        )
        ** 0.5
    )
