"""Alternatives to the methods of paper D, and its own remedies tried."""
