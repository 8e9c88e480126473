"""Paper B: where an underwater vehicle docks for its arm to be dexterous over a task area."""
