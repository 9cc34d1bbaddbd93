"""What a run writes: fields, tables, summary, plots and checkpoints. Heavy libraries are imported when they write."""
