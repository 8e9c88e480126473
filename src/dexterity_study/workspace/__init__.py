"""Paper C: the workspace of serial manipulators by learned Jacobians."""
