"""What the engine is held against: closed forms, its own convergence, state functions, independent codes."""
