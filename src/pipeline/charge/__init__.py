"""Charging a battery: waveforms, protocols and the engine that runs them."""
