"""Paper A: dexterity of an underwater vehicle-manipulator system."""
