"""Paper D: positioning of a large flexible crane."""
