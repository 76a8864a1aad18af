"""The tracking algorithms, a module each: `numbers` makes its parameters, `decide` a duty from a measurement."""
