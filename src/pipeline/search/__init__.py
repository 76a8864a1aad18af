"""Searches over a box: the chaotic swarm, the sweep that proves it, and what compares them."""
