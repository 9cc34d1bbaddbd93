"""Uncertainty of the results of a sweep: sensitivity indices, and propagation by
samples and by gradients.
"""
