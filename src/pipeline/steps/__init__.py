"""One thin module per step: artefacts in, domain calls, artefacts out."""
