"""`python -m pipeline new experiment NAME`: a working skeleton of an experiment, to be changed into one's own.

A word of the project's own repository: an experiment is code, and goes into a clone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from string import Template

from pipeline.commands import Parser, as_typed, typed
from pipeline.errors import UserError
from pipeline.kernel import registry
from pipeline.kernel.places import INSTALLED, PROJECT
from pipeline.kernel.store import write_text

SKELETON = Path(__file__).with_name("skeleton")
# Template -> where it goes, from the project's root.
PLACES = {
    "init.py.tmpl": "src/pipeline/experiments/$name/__init__.py",
    "declaration.py.tmpl": "src/pipeline/experiments/$name/declaration.py",
    "step.py.tmpl": "src/pipeline/experiments/$name/$name.py",
    "page.py.tmpl": "src/pipeline/experiments/$name/page.py",
    "figure.py.tmpl": "src/pipeline/experiments/$name/figures/${name}_curve.py",
    "study.yaml.tmpl": "conf/study/${name}_study.yaml",
    "test.py.tmpl": "tests/experiments/$name/test_$name.py",
}


def main(arguments: Sequence[str]) -> int:
    """Write the skeleton; return 0."""
    parser = Parser(prog=typed("new"), description=as_typed(__doc__ or ""))
    parser.add_argument("what", choices=["experiment"], help="what to write")
    parser.add_argument("name", help="its name: small letters, digits and underscores")
    choices = parser.parse_args(arguments)
    written = list(write(choices.name, PROJECT))
    print("\n".join(f"wrote {path}" for path in written))
    name = choices.name
    print(
        f"run it:   snakemake --cores 2 {name}_study\n"
        f"test it:  python -m pytest tests/experiments/{name}\n"
        f"see it:   {typed('steps')} {name}"
    )
    return 0


def write(name: str, project: Path) -> Iterator[Path]:
    """Write the skeleton of an experiment; yield the path of every file, from the project's root.

    Raises
    ------
    UserError : a name that is taken or is none; nothing is written.
    """
    if INSTALLED:
        raise UserError(
            "new experiment: an experiment is code, and goes into a clone of the project; here is an installed package"
        )
    if not (name.isidentifier() and name == name.lower()):
        raise UserError(f"new experiment {name!r}: allowed are small letters, digits and underscores, a letter first")
    taken = {*registry.experiments(), *registry.steps(), *registry.labels(), *registry.targets()}
    files = {file: Path(Template(place).substitute(name=name)) for file, place in PLACES.items()}
    there = [path.as_posix() for path in files.values() if (project / path).exists()]
    if name in taken or there:
        raise UserError(f"new experiment {name!r}: taken{': ' + there[0] if there else ''}; take another name")
    title = name.replace("_", " ")
    words = {"name": name, "title": title, "Title": title.capitalize(), "Class": title.title().replace(" ", "")}
    for file, path in files.items():
        write_text(project / path, Template((SKELETON / file).read_text(encoding="utf-8")).substitute(words))
        yield path
