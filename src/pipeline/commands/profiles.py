"""How Snakemake runs the jobs: the folders of `profiles/`, and what planning takes from them."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.errors import UserError, best_matches
from pipeline.kernel import places


class Profile(NamedTuple):
    """A profile.

    `name` as it was asked for, `folder` that of its `config.yaml`; `jobs` at a time and the work `job_s` that a job of
    a sweep has at least [s], where it says so.
    """

    name: str
    folder: Path
    jobs: int | None = None
    job_s: float = 0.0

    def words(self) -> list[str]:
        """Return the words of Snakemake's command line that choose it."""
        # Beside a profile Snakemake reads profiles/default, which would go before it; not so one of the workflow.
        return ["--profile" if self.name == DEFAULT.name else "--workflow-profile", str(self.folder)]


DEFAULT = Profile("default", places.place("profiles/default"))


def names() -> list[str]:
    """Return the names of the profiles, the default first."""
    roots = (places.PROJECT, places.SHIPPED)
    found = {path.parent.name for root in roots for path in (root / "profiles").glob("*/config.yaml")}
    return [DEFAULT.name, *sorted(found - {DEFAULT.name})]


def opened(asked: str) -> Profile:
    """Return a profile by its name or its folder.

    Raises
    ------
    UserError : there is none, it cannot be read, or what it submits by is not installed.
    """
    if asked == DEFAULT.name:
        return DEFAULT
    folder = Path(asked) if "/" in asked else places.place(f"profiles/{asked}")
    if not (folder / "config.yaml").is_file():
        raise UserError(f"--profile {asked}: no config.yaml in {folder}; {best_matches(asked, names())}")
    says, sweep = _read(folder / "config.yaml"), _read(folder / "sweep.yaml")
    _need_executor(asked, says.get("executor"))
    unknown = sorted(set(sweep) - {"job_s"})
    if unknown:
        raise UserError(f"{folder / 'sweep.yaml'}: {unknown[0]}: unknown; allowed is job_s")
    jobs, job_s = says.get("jobs"), sweep.get("job_s", 0.0)
    if isinstance(job_s, bool) or not isinstance(job_s, int | float) or job_s < 0:
        raise UserError(f"{folder / 'sweep.yaml'}: job_s: {job_s!r} is no work of a job; allowed are seconds from 0 on")
    return Profile(asked, folder, jobs if isinstance(jobs, int) and jobs > 0 else None, float(job_s))


def _read(path: Path) -> dict[str, Any]:
    import yaml

    if not path.is_file():
        return {}
    try:
        found = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise UserError(f"{path}: cannot be read: {' '.join(str(error).split())}") from None
    if not isinstance(found, dict):
        raise UserError(f"{path}: no mapping of keys to values")
    return found


def _need_executor(asked: str, executor: Any) -> None:
    module = f"snakemake_executor_plugin_{str(executor).replace('-', '_')}"
    if executor in (None, "local", "dryrun", "touch") or find_spec(module) is not None:
        return
    raise UserError(
        f"--profile {asked}: Snakemake's executor {executor} is not installed here; make setup-{executor}, and use "
        f".venv-{executor}/bin/python in place of this one (docs/clusters.md)"
    )
