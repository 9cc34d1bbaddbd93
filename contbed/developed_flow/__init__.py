"""Fully developed flow of gas and particles across a riser or pipe."""
