# A rule for every step, as its experiment declares it.
for step, declared in flow.steps().items():

    rule:
        name:
            declared["rule"]
        input:
            lambda wildcards: flow.needs(wildcards.chunk, carried),
        output:
            report(
                of_machine(step, flow.receipt(step)),
                caption="report/step.rst",
                category="Steps",
                subcategory=declared["rule"].replace("_", " "),
                labels={"job": "{chunk}"},
            ),
            *flow.archives(step, carried),
        log:
            kept_here(flow.log(step)),
        benchmark:
            kept_here(flow.benchmark(step))
        priority: declared["priority"]
        threads: lambda wildcards: flow.takes(wildcards.chunk, "threads")
        resources:
            mem_mb=takes("mem_mb"),
            runtime=takes("runtime"),
        params:
            command=command(step, declared["rule"]),
        message:
            declared["message"]
        shell:
            "{params.command}"
