"""Derivatives of results by keys of a scene: tangents where a model has them, else
differences.
"""
