"""Declarative battery charging studies: configuration in, charge traces, figures and verdicts out."""
