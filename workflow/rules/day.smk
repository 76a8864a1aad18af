# Days in the sun: the weather of each, what it could bring the battery, then each mode's charge in it.
rule make_weather:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("weather"),
    log:
        flow.log("weather"),
    benchmark:
        flow.benchmark("weather")
    params:
        again=again("make_weather"),
    message:
        "Weather of a day: {wildcards.chunk}"
    shell:
        flow.command("weather")


rule follow_daylight:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("daylight"),
    log:
        flow.log("daylight"),
    benchmark:
        flow.benchmark("daylight")
    params:
        again=again("follow_daylight"),
    message:
        "Daylight, from panel to battery: {wildcards.chunk}"
    shell:
        flow.command("daylight")


rule charge_over_day:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("day"),
    log:
        flow.log("day"),
    benchmark:
        flow.benchmark("day")
    params:
        again=again("charge_over_day"),
    message:
        "Day in the sun: {wildcards.chunk}"
    shell:
        flow.command("day")


rule day:
    input:
        flow.target("day"),
