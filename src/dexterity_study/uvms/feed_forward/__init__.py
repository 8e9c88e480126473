"""Feed-forward networks for w and KCI and their design loop, sections 3.2, 3.3, 4.3 and 4.4 of paper A."""
