"""Verification that ships with contbed: exact solutions, manufactured solutions, convergence and stress studies."""
