"""Peers on the common model: each module builds a function that computes the end of the same pulses."""
