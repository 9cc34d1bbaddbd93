"""The course of a run in time: series and their cuts, steps, history, cycles.

Packed beds, reacting beds and single particles share it; each gives the content, the
residual and the account of a step.
"""
