"""Generalised regression neural networks: kernels, data, selection of centres, and the neuro-fuzzy peer."""
