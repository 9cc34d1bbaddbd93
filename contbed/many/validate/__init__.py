"""Measured beds: their scenes and data, and the score of the models against them."""
