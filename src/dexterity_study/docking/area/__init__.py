"""Manipulability over the task area, its maps, and the angles of Table 4, sections III.A and IV of paper B."""
