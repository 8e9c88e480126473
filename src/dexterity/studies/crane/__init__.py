"""Studies of paper D, on a flexible log crane."""
