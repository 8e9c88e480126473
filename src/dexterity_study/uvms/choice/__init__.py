"""Which network to use, and whether to use one: the networks judged, improved, pruned and put elsewhere; sections 4.5 and 5 of paper A."""
