"""Every configuration of an arm at a pose, and what its limits leave of them, section III.A of paper B."""
