"""Compiled functions, where their code is kept on disk, and how they use several
cores.
"""
