"""Files as people have them: weather, loads, tables; read, checked, and refused in words that help."""
