"""Figures: one figure card and the artefacts it reads in; the figure as SVG and PNG out."""

from __future__ import annotations

