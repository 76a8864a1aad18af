"""The figures, a module each with one public function `draw`."""
