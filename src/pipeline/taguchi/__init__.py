"""Parameter design by orthogonal arrays: the arrays, what they tell, and whether that can be trusted."""
