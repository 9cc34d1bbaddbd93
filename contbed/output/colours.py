"""Colours of curves, distinct for any colour vision."""

# Okabe and Ito 2008, jfly.uni-koeln.de/color
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
