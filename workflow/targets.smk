# What people can ask for beside `all`: parts of a run, each study by its name, any file by its path.
for name in [*flow.targets(), *flow.studies(), *flow.requests()]:

    rule:
        name:
            name
        input:
            [kept_here(path) for path in flow.target(name)],


for path, chunk in flow.files().items():

    rule:
        name:
            f"place_{flow.word(chunk)}"
        input:
            ancient(flow.needs(chunk)),
        output:
            report(
                flow.placed(path, chunk),
                caption="report/file.rst",
                category=path.split("/")[1],
                subcategory=path.split("/")[2],
                labels={"file": path.split("/", 3)[3]},
            ),
        log:
            flow.log("publish").format(chunk=chunk),
        resources:
            mem_mb=flow.takes(chunk, "mem_mb"),
            runtime=flow.takes(chunk, "runtime"),
        params:
            command=flow.command("publish", chunk),
            told=flow.told(path),
        message:
            f"Placing: {path}"
        shell:
            "{params.command}"
