"""Studies of Part I: the dexterity of an underwater vehicle-manipulator system (paper A)."""
