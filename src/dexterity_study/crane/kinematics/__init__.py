"""The rigid crane from its strokes to the tip and back, Appendices A and B of paper D."""
