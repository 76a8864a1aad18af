# The network that commands a charger: its data, the selections of its centres, its size, its kernel.
rule make_surface:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("surface"),
    log:
        flow.log("surface"),
    benchmark:
        flow.benchmark("surface")
    params:
        again=again("make_surface"),
    message:
        "Surface: the data of the network, and what could stand in for them: {wildcards.chunk}"
    shell:
        flow.command("surface")


rule select_centres:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("network"),
    log:
        flow.log("network"),
    benchmark:
        flow.benchmark("network")
    params:
        again=again("select_centres"),
    message:
        "Network: centres selected by every method: {wildcards.chunk}"
    shell:
        flow.command("network")


rule size_network:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("network_size"),
    log:
        flow.log("network_size"),
    benchmark:
        flow.benchmark("network_size")
    # The longest job: begun last, it would run alone.
    priority: 10
    params:
        again=again("size_network"),
    message:
        "Network size: error against the number of centres: {wildcards.chunk}"
    shell:
        flow.command("network_size")


rule vary_kernel:
    input:
        lambda wildcards: flow.needs(wildcards.chunk),
    output:
        flow.receipt("network_kernels"),
    log:
        flow.log("network_kernels"),
    benchmark:
        flow.benchmark("network_kernels")
    priority: 5
    params:
        again=again("vary_kernel"),
    message:
        "Network kernels: error under every kernel on every surface: {wildcards.chunk}"
    shell:
        flow.command("network_kernels")
