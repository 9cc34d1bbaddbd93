"""From particles to the results of a bed, with the uncertainty of all steps between."""
