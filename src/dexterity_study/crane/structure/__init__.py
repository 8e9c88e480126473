"""The structure of the crane, its training data and its errors without compensation, chapters 2 to 4 of paper D."""
