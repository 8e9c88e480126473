"""Networks that stand in for dexterity indices: made, trained, judged, and exported."""
