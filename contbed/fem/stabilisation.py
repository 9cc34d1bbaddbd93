"""Stabilisation of convection by streamline upwinding (SUPG)."""

from __future__ import annotations

from typing import Any


def tau(c_flux: Any, conductivity: Any, exchange: Any, capacity: float, h: Any, degree: int) -> Any:
    """Stabilisation parameter for cells of size `h`: its three limits are convection, conduction and exchange.

    tau / capacity = ((2 C u / h)^2 + 9 (4 k / h^2)^2 + (h a)^2)^(-1/2), h over the degree; `c_flux` is C u [W/m2/K].
    Shakib, Hughes & Johan 1991, doi:10.1016/0045-7825(91)90041-4.
    """
    h = h / degree
    return capacity / ((2.0 * c_flux / h) ** 2 + 9.0 * (4.0 * conductivity / h**2) ** 2 + exchange**2) ** 0.5
