"""A scene made into a problem that the solvers take: coefficients, unknowns, boundary values, and what is found."""
