"""Where the data sets of paper A come from, and how much depends on that."""
