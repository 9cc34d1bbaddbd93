"""A report of one or several runs, or of a sweep: one self-contained HTML file of
what was asked and what was found.
"""
