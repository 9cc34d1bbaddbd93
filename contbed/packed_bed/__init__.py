"""Packed and moving beds: two energy equations, flow through the bed, closed form; scene,
plan, run, results.
"""
