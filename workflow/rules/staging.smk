# The currents of a staged charge: every search, what they come to, the front of time and temperature rise.


rule search_stage_currents:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("staging_search"),
    log:
        flow.log("staging_search"),
    benchmark:
        flow.benchmark("staging_search")
    params:
        again=again("search_stage_currents"),
    message:
        "Staging: searches for stage currents, with all replicates: {wildcards.chunk}"
    shell:
        flow.command("staging_search")


rule gather_stage_currents:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("staging"),
    log:
        flow.log("staging"),
    benchmark:
        flow.benchmark("staging")
    params:
        again=again("gather_stage_currents"),
    message:
        "Staging: the best currents, and the searches against them: {wildcards.chunk}"
    shell:
        flow.command("staging")


rule trade_time_for_rise:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("front"),
    log:
        flow.log("front"),
    benchmark:
        flow.benchmark("front")
    params:
        again=again("trade_time_for_rise"),
    message:
        "Front: charging time against temperature rise, under each calibration: {wildcards.chunk}"
    shell:
        flow.command("front")
