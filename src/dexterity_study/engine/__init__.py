"""The engine of the study: readings of the papers, and the tasks that compute evidence under them."""
