"""Packed and moving beds: two energy equations, flow through the bed, fronts; scene,
plan, run, results.
"""
