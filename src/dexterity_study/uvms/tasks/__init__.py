"""Tasks and the indices that rank configurations for them, Table 1 of paper A."""
