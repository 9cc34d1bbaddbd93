"""The field of one emission between walls by discrete ordinates."""

from contbed.radiation.equations.ordinates import Ordinates


def solve_ordinates(z, Ka, Ks, emission, left, right, order=4, degree=2):
    """Solve for an emission [W/m3]; None is radiative equilibrium, 4 e = Ka G, which is
    even scattering.
    """
    if emission is None:
        Ka, Ks, emission = 0.0, Ka + Ks, 0.0
    return Ordinates(z, Ka, Ks, left, right, order, degree).solve(emission)
