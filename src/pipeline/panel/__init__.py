"""The photovoltaic panel: data sheet in, single-diode parameters, curves and maximum power out."""
