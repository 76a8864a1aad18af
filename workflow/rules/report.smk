# From artefacts to verdicts, figures, the page, and the readable view.
rule judge_statements:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("verdicts"),
    params:
        again=again("judge_statements"),
    log:
        flow.log("verdicts"),
    benchmark:
        flow.benchmark("verdicts")
    message:
        "Verdicts on the published statements: {wildcards.chunk}"
    shell:
        flow.command("verdicts")


rule draw_figures:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("figures"),
    params:
        again=again("draw_figures"),
    log:
        flow.log("figures"),
    benchmark:
        flow.benchmark("figures")
    message:
        "Figures: {wildcards.chunk}"
    shell:
        flow.command("figures")


rule write_page:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("page"),
    params:
        again=again("write_page"),
    log:
        flow.log("page"),
    benchmark:
        flow.benchmark("page")
    message:
        "Report page: {wildcards.chunk}"
    shell:
        flow.command("page")


rule publish_run:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("publish"),
    params:
        again=again("publish_run"),
    log:
        flow.log("publish"),
    benchmark:
        flow.benchmark("publish")
    message:
        "Publishing: {wildcards.chunk}"
    shell:
        flow.command("publish")
