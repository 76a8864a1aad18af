# Searches on test functions: a job for each function, then what they come to together.
rule run_on_function:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("function_runs"),
    log:
        flow.log("function_runs"),
    benchmark:
        flow.benchmark("function_runs")
    params:
        again=again("run_on_function"),
    message:
        "Test function, every search in every placement: {wildcards.chunk}"
    shell:
        flow.command("function_runs")


rule compare_on_functions:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("functions"),
    log:
        flow.log("functions"),
    benchmark:
        flow.benchmark("functions")
    params:
        again=again("compare_on_functions"),
    message:
        "Test functions: statistics and tests: {wildcards.chunk}"
    shell:
        flow.command("functions")
