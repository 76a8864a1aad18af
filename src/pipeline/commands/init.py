"""`python -m pipeline init FOLDER`: a project of one's own, whose configuration comes before the shipped one."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path
from string import Template

from pipeline.commands import Parser, as_typed, typed
from pipeline.errors import UserError
from pipeline.kernel.places import SHIPPED
from pipeline.kernel.plan import PYTHON
from pipeline.kernel.planfile import studies
from pipeline.kernel.store import write_text

TEMPLATES = Path(__file__).with_name("skeleton") / "project"
# Template -> where it goes in the project.
PLACES = {
    "Snakefile.tmpl": "Snakefile",
    "README.md.tmpl": "README.md",
    "gitignore.tmpl": ".gitignore",
    "reproduce.yml.tmpl": ".github/workflows/reproduce.yml",
    "config.yaml.tmpl": "conf/config.yaml",
    "study.yaml.tmpl": "conf/study/$name.yaml",
    "pulse.yaml.tmpl": "conf/modes/${name}_pulse.yaml",
    "reflex.yaml.tmpl": "conf/modes/${name}_reflex.yaml",
    "battery.yaml.tmpl": "conf/battery/${name}_battery.yaml",
}
COPIED = ("profiles/default/config.yaml", "requirements.lock")
"""What a project has as it is shipped."""


def main(arguments: Sequence[str]) -> int:
    """Write the project; return 0."""
    parser = Parser(prog=typed("init"), description=as_typed(__doc__ or ""))
    parser.add_argument("folder", type=Path, help="where; must be empty or not there yet")
    parser.add_argument("--name", help="of its study (the folder's name)")
    choices = parser.parse_args(arguments)
    written = list(write(choices.folder, choices.name))
    print("\n".join(f"wrote {choices.folder / path}" for path in written))
    print(f"run it:   cd {choices.folder} && snakemake --cores 2 all")
    return 0


def write(folder: Path, name: str | None = None) -> Iterator[Path]:
    """Write a project; yield the path of every file in it.

    Raises
    ------
    UserError : a folder that holds something, or a name that a study cannot have; nothing is written.
    """
    if folder.exists() and (not folder.is_dir() or any(one.name != ".git" for one in folder.iterdir())):
        raise UserError(f"init {folder}: is there and not empty; give a new folder")
    chosen = name or re.sub(r"\W+", "_", folder.resolve().name.lower()).strip("_")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", chosen) or chosen in studies():
        raise UserError(
            f"init {folder}: {chosen!r} cannot name its study; give --name, small letters, digits and underscores, "
            f"none of {', '.join(studies())}"
        )
    words = {
        "name": chosen,
        "Title": chosen.replace("_", " ").capitalize(),
        "python": PYTHON,
        "version": metadata.version("charge-pipeline"),
    }
    for file, place in PLACES.items():
        path = Path(Template(place).substitute(words))
        write_text(folder / path, Template((TEMPLATES / file).read_text(encoding="utf-8")).substitute(words))
        yield path
    for place in COPIED:
        write_text(folder / place, (SHIPPED / place).read_text(encoding="utf-8"))
        yield Path(place)
