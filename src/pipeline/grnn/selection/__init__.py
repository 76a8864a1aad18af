"""How centres are selected from the data; each module holds `select(problem, random)`, `methods` lists them."""
