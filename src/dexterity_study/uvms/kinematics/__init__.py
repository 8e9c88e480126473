"""Kinematics of the vehicle with its arm, sections 2.1, 2.2 and 3.1 of paper A."""
