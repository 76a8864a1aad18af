# What the engine is held against: a job for each check.
rule check_engine:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("validation"),
    log:
        flow.log("validation"),
    benchmark:
        flow.benchmark("validation")
    params:
        again=again("check_engine"),
    message:
        "Validation: {wildcards.chunk}"
    shell:
        flow.command("validation")
