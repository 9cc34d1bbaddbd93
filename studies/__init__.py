"""Studies: scenes with what they are compared with. `python -m studies` lists them."""
