"""A network in place of the area manipulability over many control points, where that is dear."""
