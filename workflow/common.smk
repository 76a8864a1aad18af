# What the rules share: the plan as Snakemake sees it.
from pipeline.workflow import forced, open_workflow

flow = open_workflow(config, tidy=workflow.is_main_process)


# A forced job computes what is there already and compares.
def again(rule_name):
    return lambda wildcards: (
        "--again" if forced(rule_name, workflow.dag_settings) else ""
    )


wildcard_constraints:
    chunk=r"[^/]+",
