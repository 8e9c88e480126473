"""Docking poses by the genetic algorithm and the true optimum, sections III.B to V of paper B."""
