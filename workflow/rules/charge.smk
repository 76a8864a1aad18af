# The charges, after one job that compiles the engine for all of them.
rule compile_engine:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("engine"),
    log:
        flow.log("engine"),
    benchmark:
        flow.benchmark("engine")
    params:
        again=again("compile_engine"),
    message:
        "Engine: compiling the kernels (once for each version of their code): {wildcards.chunk}"
    shell:
        flow.command("engine")


rule charge_battery:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("charge"),
    log:
        flow.log("charge"),
    benchmark:
        flow.benchmark("charge")
    params:
        again=again("charge_battery"),
    message:
        "Charge: {wildcards.chunk}"
    shell:
        flow.command("charge")


rule switch_converters:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("switched"),
    log:
        flow.log("switched"),
    benchmark:
        flow.benchmark("switched")
    params:
        again=again("switch_converters"),
    message:
        "Converters, switch by switch: {wildcards.chunk}"
    shell:
        flow.command("switched")


rule charge_ensemble:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("ensemble"),
    log:
        flow.log("ensemble"),
    benchmark:
        flow.benchmark("ensemble")
    params:
        again=again("charge_ensemble"),
    message:
        "Charges over the ranges of estimated parameters: {wildcards.chunk}"
    shell:
        flow.command("ensemble")


rule weigh_time_against_temperature:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("trade_off"),
    log:
        flow.log("trade_off"),
    benchmark:
        flow.benchmark("trade_off")
    params:
        again=again("weigh_time_against_temperature"),
    message:
        "Charge time against peak temperature: {wildcards.chunk}"
    shell:
        flow.command("trade_off")
