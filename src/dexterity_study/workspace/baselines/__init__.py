"""Other methods of machine learning on the data of paper C, section VI.A, Tables VI and VII."""
