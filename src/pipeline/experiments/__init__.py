"""The experiments: one package a capability, each found by its folder, each exporting one `EXPERIMENT`."""
