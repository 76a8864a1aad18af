"""Weather as columns over time: constant, clear or cloudy for a place and date, or measured."""
