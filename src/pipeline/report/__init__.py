"""The report: figures, tables and pages made from artefacts alone."""
