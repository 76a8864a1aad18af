"""Published statements: what a paper says, as predicates, and the verdict our artefacts give on each."""
