"""One particle of a bed: its rate of reaction and its inside, as functions of the
state around it.
"""
