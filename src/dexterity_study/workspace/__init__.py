"""Paper C: networks for the reach of a manipulator and its Jacobian."""
