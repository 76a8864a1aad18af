# From the panel's data sheet to the power that reaches the battery.
rule fit_panel:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("panel"),
    log:
        flow.log("panel"),
    benchmark:
        flow.benchmark("panel")
    params:
        again=again("fit_panel"),
    message:
        "Panel: parameters, curves, maximum power: {wildcards.chunk}"
    shell:
        flow.command("panel")


rule power_supply:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("supply"),
    log:
        flow.log("supply"),
    benchmark:
        flow.benchmark("supply")
    params:
        again=again("power_supply"),
    message:
        "Supply: power at the battery's terminals: {wildcards.chunk}"
    shell:
        flow.command("supply")


rule try_trackers:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("tracking"),
    log:
        flow.log("tracking"),
    benchmark:
        flow.benchmark("tracking")
    params:
        again=again("try_trackers"),
    message:
        "Trackers: ramps, days, shadows: {wildcards.chunk}"
    shell:
        flow.command("tracking")


rule look_at_converters:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("converters"),
    log:
        flow.log("converters"),
    benchmark:
        flow.benchmark("converters")
    params:
        again=again("look_at_converters"),
    message:
        "Converters: efficiency over load: {wildcards.chunk}"
    shell:
        flow.command("converters")
