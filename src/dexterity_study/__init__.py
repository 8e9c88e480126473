"""The study of four papers: what they claim, what was computed, and what became of each claim."""
