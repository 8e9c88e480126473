"""The control loop of paper C at many gains, sections III.A and VII."""
