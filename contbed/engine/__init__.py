"""Evaluates weak forms: `dual` values with exact derivatives, `skfem` assembly, `ufl_forms` for UFL and FFCx."""
