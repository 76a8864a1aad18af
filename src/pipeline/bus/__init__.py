"""The bus between the converters: its load, its switches, and the powers that meet on it."""
