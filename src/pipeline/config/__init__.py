"""Composes `conf/` with Hydra, validates it, and tells where every value came from."""
