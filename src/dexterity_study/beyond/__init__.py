"""Part V: the library, beyond what the papers ask."""
