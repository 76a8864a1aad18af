"""The words that `python -m pipeline` understands, one module each."""
