"""Four ways to bring the loaded tip to a point, sections 2.4.6 and 4.1 to 4.5 of paper D."""
