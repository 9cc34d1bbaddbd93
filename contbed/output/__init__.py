"""Output of a run: fields, tables, summary, plots and checkpoints. Libraries are
imported when they write.
"""
