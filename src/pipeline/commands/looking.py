"""What a Hydra user expects to see without a run: --cfg, --info, and the words that a shell completes."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from typing import Any

from pipeline.commands import COMMANDS
from pipeline.errors import UserError, best_matches
from pipeline.kernel import kept, places
from pipeline.kernel.code import of_code
from pipeline.kernel.digest import of_folder, of_value

SHELLS = {
    "bash": """\
_charge_pipeline() {
    local IFS=$'\\n' line="${COMP_LINE:0:$COMP_POINT}"
    COMPREPLY=($(charge-pipeline completion --words "$line" 2>/dev/null))
    # What stands before the last = is typed already, and bash completes behind it.
    local typed="${line##* }" before="${line##* }"
    [[ "$COMP_WORDBREAKS" == *=* && "$typed" == *=* ]] && COMPREPLY=("${COMPREPLY[@]#"${before%=*}="}")
}
complete -o nospace -F _charge_pipeline charge-pipeline
""",
    "zsh": """\
#compdef charge-pipeline
_charge_pipeline() { compadd -S '' -- ${(f)"$(charge-pipeline completion --words "${BUFFER[1,$CURSOR]}" 2>/dev/null)"} }
compdef _charge_pipeline charge-pipeline
""",
    "fish": """\
complete -c charge-pipeline -f -a '(charge-pipeline completion --words (commandline -cp) 2>/dev/null)'
""",
}
HYDRA = (
    "# Of Hydra's own settings none is used: runs lie in results/<study>/<run>, sweeps in\n"
    "# results/<study>/sweeps/<name>, logs in results/logs; Snakemake starts the jobs (--cores, --profile).\n"
)


def main(arguments: Sequence[str]) -> int:
    """Print the lines that teach a shell to complete, or what completes a line."""
    if len(arguments) == 2 and arguments[0] == "--words":
        print("\n".join(completed(arguments[1])))
        return 0
    if len(arguments) != 1 or arguments[0] not in SHELLS:
        raise UserError(
            'completion: give the shell, bash, zsh or fish; e.g. in bash: eval "$(charge-pipeline completion bash)"'
        )
    print(SHELLS[arguments[0]], end="")
    return 0


def shown(run: Sequence[str], what: str, package: str | None) -> str:
    """Return a run's configuration as YAML, resolved; what of Hydra is used instead of its own; or both.

    Arguments
    ---------
    run : overrides.
    what : `job`, `hydra` or `all`.
    package : key path of the part to return; all of it where None.

    Raises
    ------
    UserError : a configuration that does not compose or validate, or without that part.
    """
    import yaml

    from pipeline.config.compose import compose_tree
    from pipeline.config.study import study_from

    if what == "hydra":
        return HYDRA
    here: Any = study_from(compose_tree(run)).configuration
    for word in package.split(".") if package else ():
        if not isinstance(here, Mapping) or word not in here:
            known = here if isinstance(here, Mapping) else ()
            raise UserError(f"--package {package}: no {word!r} there; {best_matches(word, known)}")
        here = here[word]
    text = f"# @package {package}\n" if package else ""
    text += yaml.safe_dump(here, sort_keys=False, allow_unicode=True)
    return f"{HYDRA}{text}" if what == "all" else text


def told(run: Sequence[str]) -> Iterator[str]:
    """Yield what composes a run: versions, the folders searched, the files in the order in which they are put in."""
    from pipeline.config.compose import compose_tree
    from pipeline.config.yaml_file import shown as name

    composed = compose_tree(run)
    packages = ("hydra-core", "omegaconf", "snakemake", "numpy", "numba")
    yield f"Python {sys.version.split()[0]}, " + ", ".join(f"{one} {version(one)}" for one in packages)
    yield "searched: " + ", ".join(str(folder) for folder in places.confs())
    yield f"kernels and remembered plans: {places.cache_root()}"
    yield "files, a later one goes before an earlier one:"
    for layer in composed.layers:
        yield f"  {name(layer.file)}" + (f" at {'.'.join(layer.place)}" if layer.place else "")
    yield "overrides: " + (" ".join(composed.overrides) or "none")


def completed(line: str) -> list[str]:
    """Return the words that a last, begun word may become.

    Arguments
    ---------
    line : what is typed so far, the command first.
    """
    words = line.split(" ")
    begun, before = words[-1], [word for word in words[1:-1] if word]
    listed = _listed(next((word for word in before if word.startswith("study=")), ""))
    if "=" in begun:
        key, _, value = begun.partition("=")
        values, _, last = value.rpartition(",")
        head = f"{key}={values}," if values else f"{key}="
        options = listed["groups"].get(key.lstrip("+~").split("@")[0], [])
        return [f"{head}{option}" for option in options if option.startswith(last)]
    depth = begun.count(".") + 1
    keys = {".".join(key.split(".")[:depth]) + ("." if key.count(".") >= depth else "=") for key in listed["keys"]}
    keys |= {f"{group}=" for group in listed["groups"]}
    found = sorted(key for key in keys if key.startswith(begun))
    return [*(word for word in COMMANDS if not before and word.startswith(begun)), *found]


def _listed(study: str) -> dict[str, Any]:
    """Return groups with their options and every key path of a study, kept until the configuration changes.

    Arguments
    ---------
    study : the word that chooses it; where empty, the one that conf/config.yaml names.
    """
    from pipeline.config.compose import compose_tree, groups, options

    state = of_value([study, of_code(__name__), *(of_folder(folder) for folder in places.confs())])
    listed: dict[str, Any] | None = kept.read(f"completion/{state}.json")
    if listed is None:
        tree = compose_tree([study] if study else []).tree
        listed = {"groups": {group: options(group) for group in groups()}, "keys": sorted(_keys(tree, ""))}
        kept.write(f"completion/{state}.json", listed, 8)
    return listed


def _keys(tree: Mapping[str, Any], path: str) -> Iterator[str]:
    for name, value in tree.items():
        if name == "sources":
            continue
        # A value that another step finds is one value, however it is written.
        inside = isinstance(value, Mapping) and value and "from" not in value
        yield from _keys(value, f"{path}{name}.") if inside else (f"{path}{name}",)
