# From artefacts to verdicts, figures, the page, and the readable view.
rule judge_statements:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("verdicts"),
    log:
        flow.log("verdicts"),
    benchmark:
        flow.benchmark("verdicts")
    params:
        again=again("judge_statements"),
    message:
        "Verdicts on the published statements: {wildcards.chunk}"
    shell:
        flow.command("verdicts")


rule draw_figures:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("figures"),
    log:
        flow.log("figures"),
    benchmark:
        flow.benchmark("figures")
    params:
        again=again("draw_figures"),
    message:
        "Figures: {wildcards.chunk}"
    shell:
        flow.command("figures")


rule write_page:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("page"),
    log:
        flow.log("page"),
    benchmark:
        flow.benchmark("page")
    params:
        again=again("write_page"),
    message:
        "Report page: {wildcards.chunk}"
    shell:
        flow.command("page")


rule publish_run:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("publish"),
    log:
        flow.log("publish"),
    benchmark:
        flow.benchmark("publish")
    params:
        again=again("publish_run"),
    message:
        "Publishing: {wildcards.chunk}"
    shell:
        flow.command("publish")
