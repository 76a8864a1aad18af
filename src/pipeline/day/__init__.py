"""A day in the sun: weather, panel, bus and battery together."""
