"""The field of one emission between walls by discrete ordinates."""

from contbed.radiation.equations.ordinates import Ordinates


def solve_ordinates(z, Ka, Ks, emission, left, right, order=4, degree=2):
    """Solve for an emission [W/m3]; None is radiative equilibrium, 4 e = Ka G."""
    balanced = emission is None
    bed = Ordinates(z, Ka, Ks, left, right, order, degree, equilibrium=balanced)
    return bed.solve(emission)
