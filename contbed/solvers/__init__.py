"""Solvers: linear systems, Newton's method, time steps, pseudo-transient
continuation and branches.
"""
