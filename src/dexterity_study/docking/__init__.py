"""Paper B: docking of an underwater vehicle with its arm."""
