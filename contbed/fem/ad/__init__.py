"""Derivatives of pointwise forms: by dual numbers, or recorded once as a graph of
operations.

To read in this order: `dual`, `graph`, `plan`, `elimination`, `batched`. A graph is
evaluated with its derivatives (`batched`) or becomes a form of UFL (`contbed.ranks`).
"""
