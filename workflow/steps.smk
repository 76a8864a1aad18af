# A rule for every step, as its experiment declares it.
for step, declared in flow.steps().items():

    rule:
        name:
            declared["rule"]
        input:
            lambda wildcards: flow.needs(wildcards.chunk),
        output:
            report(
                flow.receipt(step),
                caption="report/step.rst",
                category="Steps",
                subcategory=declared["rule"].replace("_", " "),
                labels={"job": "{chunk}"},
            ),
        log:
            flow.log(step),
        benchmark:
            flow.benchmark(step)
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
