"""One file, one physics: equations, fields, residual, boundary terms, balances."""
