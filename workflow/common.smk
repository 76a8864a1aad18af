# What the rules share: the plan as Snakemake sees it.
from snakemake.logging import logger

from pipeline.commands.terminal import quieten
from pipeline.commands.workflow import forced, open_workflow

quieten(logger, workflow.output_settings)
flow = open_workflow(config, workflow.is_main_process)


# The command of a step's jobs; a forced job computes what is there already and compares.
def command(step, rule_name):
    return lambda wildcards: flow.command(
        step, wildcards.chunk, forced(rule_name, workflow.dag_settings)
    )


wildcard_constraints:
    chunk=r"[^/]+",
