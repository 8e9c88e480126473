"""Times of a pose and of a whole grid, Tables VI and VII and section I of paper C."""
