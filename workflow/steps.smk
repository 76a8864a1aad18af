# A rule for every step, as its experiment declares it.
for step, declared in flow.steps().items():

    rule:
        name:
            declared["rule"]
        input:
            lambda wildcards: flow.needs(wildcards.chunk),
        output:
            flow.receipt(step),
        log:
            flow.log(step),
        benchmark:
            flow.benchmark(step)
        priority: declared["priority"]
        params:
            command=command(step, declared["rule"]),
        message:
            declared["message"]
        shell:
            "{params.command}"
