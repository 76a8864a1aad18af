"""The words of a notebook: charge, compare, sweep. Above the configuration and the experiments; writes nothing."""
