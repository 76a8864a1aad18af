# What the rules share: the plan as Snakemake sees it.
from snakemake.logging import logger

from pipeline.commands.terminal import quieten
from pipeline.commands.workflow import forced, open_workflow

quieten(logger, workflow.output_settings)
flow = open_workflow(config, workflow.is_main_process)

# Jobs on other machines are handed the plan: composing it anew, they would be asked for a receipt, not for a study.
if workflow.is_main_process:
    workflow.config_settings.config_args = flow.handed_on()


# What a job is to be given, by its chunk; more where it is tried again.
def takes(what):
    return lambda wildcards, attempt: flow.takes(
        wildcards.chunk, what, attempt, workflow.non_local_exec
    )


# The command of a step's jobs; a forced job computes what is there already and compares.
def command(step, rule_name):
    return lambda wildcards: flow.command(
        step, wildcards.chunk, forced(rule_name, workflow.dag_settings)
    )


wildcard_constraints:
    chunk=r"[^/]+",
