"""Files and units at the edge: case files, result files, units in text."""
