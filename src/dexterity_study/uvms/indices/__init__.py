"""Manipulability, conditioning and ellipsoids, section 2.3 of paper A."""
