"""More control points, a hovering vehicle and a vertical surface, sections IV to VI of paper B."""
