"""Times of exact indices and networks, Table 5 of paper A."""
