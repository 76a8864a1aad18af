# What people can ask for beside `all`: parts of a run, and each study by its name.
rule panel:
    input:
        flow.target("panel"),


rule tuning:
    input:
        flow.target("tuning"),


rule search:
    input:
        flow.target("search"),


rule network:
    input:
        flow.target("network"),


rule staging:
    input:
        flow.target("staging"),


rule functions:
    input:
        flow.target("functions"),


rule charges:
    input:
        flow.target("charges"),


rule figures:
    input:
        flow.target("figures"),


rule report:
    input:
        flow.target("report"),


for study in [*flow.studies(), *flow.requests()]:

    rule:
        name:
            study
        input:
            flow.target(study),
