"""Under which unprinted settings the printed numbers come out; sections 2 to 4 of paper A."""
