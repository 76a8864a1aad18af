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


# Where results lie in a bucket (--default-storage-provider), each job makes an archive beside its receipt and takes those
# of others. Readable views, logs and benchmarks are of the machine that makes them.
carried = workflow.storage_settings.default_storage_provider is not None


def kept_here(path):
    return local(path) if carried else path


def of_machine(step, path):
    return kept_here(path) if step == "publish" else path


# The command of a step's jobs; a forced job computes what is there already and compares.
def command(step, rule_name):
    def of(wildcards, take=(), give=()):
        again = forced(rule_name, workflow.dag_settings)
        return flow.command(step, wildcards.chunk, again, take, give)

    if not carried:
        return lambda wildcards: of(wildcards)
    return lambda wildcards, input, output: of(
        wildcards,
        [str(path) for path in input],
        [str(path) for path in output] if step != "publish" else (),
    )


wildcard_constraints:
    chunk=r"[^/]+",


if carried:

    localrules:
        publish_run,
