"""Plans, keys, the store, tables and the runner of a step; knows no study, no Hydra and no physics."""
