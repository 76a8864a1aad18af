"""One module per search algorithm; each holds `Settings` and `minimise`, and nothing else registers it."""
