# What is found: the map behind chaos, the loss against frequency, the tuned constants, the best frequency.
rule follow_logistic_map:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("chaos"),
    log:
        flow.log("chaos"),
    benchmark:
        flow.benchmark("chaos")
    params:
        again=again("follow_logistic_map"),
    message:
        "Chaos: orbits and disorder of the logistic map: {wildcards.chunk}"
    shell:
        flow.command("chaos")


rule loss_over_frequency:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("objective"),
    log:
        flow.log("objective"),
    benchmark:
        flow.benchmark("objective")
    params:
        again=again("loss_over_frequency"),
    message:
        "Objective: loss against frequency: {wildcards.chunk}"
    shell:
        flow.command("objective")


rule tune_search:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("tuning"),
    log:
        flow.log("tuning"),
    benchmark:
        flow.benchmark("tuning")
    params:
        again=again("tune_search"),
    message:
        "Tuning: the parameter design, printed and run anew: {wildcards.chunk}"
    shell:
        flow.command("tuning")


rule search_frequency:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("search"),
    log:
        flow.log("search"),
    benchmark:
        flow.benchmark("search")
    params:
        again=again("search_frequency"),
    message:
        "Search: the frequency, with all replicates and variants: {wildcards.chunk}"
    shell:
        flow.command("search")
