# Battery charging studies, from configuration to report.
#
#   snakemake --cores 2 all
#   snakemake --cores 2 all --config overrides="battery=lead_acid_12v18ah modes.cv_reflex.frequency_hz=50"
#
# The plan says which artefacts a configuration needs; the rules make them. What is valid is decided by keys in
# results/store, so a receipt is all that Snakemake needs to look at.
from snakemake.utils import min_version

min_version("9.0")


# Lets the linter see a reproducible environment; used with --sdm apptainer alone.
container: "docker://python:3.11-slim"


include: "workflow/common.smk"


# A charge that did not get where it was to go says so at the end, and on its page.
onsuccess:
    flow.tell(),


rule all:
    input:
        flow.target("all"),


include: "workflow/rules/targets.smk"
include: "workflow/rules/supply.smk"
include: "workflow/rules/search.smk"
include: "workflow/rules/network.smk"
include: "workflow/rules/staging.smk"
include: "workflow/rules/functions.smk"
include: "workflow/rules/charge.smk"
include: "workflow/rules/day.smk"
include: "workflow/rules/validation.smk"
include: "workflow/rules/report.smk"
