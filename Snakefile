# Battery charging studies, from configuration to report.
#
#   snakemake --cores 2 all
#   snakemake --cores 2 all --config overrides="battery=lead_acid_12v18ah modes.cv_reflex.frequency_hz=50"
#   snakemake --cores 2 reports/solar_reflex/default/figures/figure_16_battery_temperature.svg
#
# The plan says which artefacts a configuration needs; the rules make them, one for each step that an experiment
# declares (`python -m pipeline steps` prints them). What is valid is decided by keys in results/store, so a receipt
# is all that Snakemake needs to look at.
from snakemake.utils import min_version

min_version("9.0")


# Lets the linter see a reproducible environment; used with --sdm apptainer alone.
container: "docker://python:3.11-slim"


report: "workflow/report/workflow.rst"


include: "workflow/common.smk"


# A charge that did not get where it was to go says so at the end, and on its page.
onsuccess:
    flow.tell(),


rule all:
    input:
        [kept_here(path) for path in flow.target("all")],


include: "workflow/steps.smk"
include: "workflow/targets.smk"
