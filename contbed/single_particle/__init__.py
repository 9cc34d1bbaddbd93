"""One sphere in hot surroundings: conduction, reactions that turn it into gas and
char, the gas that leaves.
"""
