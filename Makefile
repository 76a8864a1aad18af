# `make all` and `make test` set up everything they need; Python 3.11, or 3.12 or 3.13, is all that must be there.
PYTHON ?= python3.11
VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)
# Python 3.11 has .venv; another version an environment of its own, .venv-3.12.
VENV := .venv$(if $(VERSION),$(filter-out -3.11,-$(VERSION)))
BIN := $(VENV)/bin
CORES ?= 2

.PHONY: check-python all test test-slow test-struck test-browser browser-setup lint bench bench-slow faults faults-short fuzz \
	fuzz-short validate accuracy reproduce reproduce-generic expected own-battery-proof setup setup-dev setup-docs \
	setup-slurm setup-s3 slurm-test bucket-test docs lock clean help

all: setup ## run every study: results/ and reports/
	$(BIN)/snakemake --cores $(CORES) all

test: setup-dev ## run the tests
	$(BIN)/python -m pytest -n $(CORES) --dist loadgroup

test-slow: setup-dev ## run the tests that take minutes
	$(BIN)/python -m pytest -n $(CORES) --dist loadgroup -m "slow and not struck"

test-struck: setup-dev ## every kind of damage by both commands, cold runs against what is expected: an hour
	$(BIN)/python -m pytest -n $(CORES) --dist loadgroup -m struck

test-browser: browser-setup ## look at the pages in Chromium: quiet, reachable, readable; screenshots under results/
	$(BIN)/python -m pytest -n 0 -m browser tests/browser

browser-setup: setup-dev ## what drives Chromium; the browser itself is Debian's: apt-get install chromium
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r requirements-browser.lock
	@for name in chromium chromium-browser google-chrome; do command -v $$name >/dev/null && exit 0; done; \
		echo "no Chromium here: apt-get install chromium"

fuzz: setup-dev ## wrong input at every front door: 1500 configurations, 340 files, 40 real commands a door; half an hour
	$(BIN)/python -m tests.fuzz

fuzz-short: setup-dev ## the same, a sample of about two minutes
	$(BIN)/python -m tests.fuzz --short

check-python: setup ## import the package and charge a battery: for PYTHON=python3.12 and python3.13
	$(BIN)/python -W error -m tests.one_charge

lint: setup-dev ## style, types, workflow
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint

bench: setup-dev ## time everything against its peers; fails where a ratio is below half of what is asked
	$(BIN)/python -m benchmarks

bench-slow: setup-dev ## the same, and the hour that PyBaMM takes minutes for
	$(BIN)/python -m benchmarks hour all

faults: setup-dev ## kills, full disks, read-only folders, by the thousand; a table of what ended right
	$(BIN)/python -m tests.faults

faults-short: setup-dev ## the same in about five minutes, for every change
	$(BIN)/python -m tests.faults --short

slurm-test: setup-slurm ## a Slurm of one node on loopback, as root with Debian's slurm-wlm and munge: jobs, faults, equal bytes
	PYTHONPATH=src:. .venv-slurm/bin/python -m tests.slurm

bucket-test: setup-s3 ## results in a bucket of moto's server on loopback: killed, gone on with elsewhere, equal bytes
	PYTHONPATH=src:. .venv-s3/bin/python -m tests.slurm.bucket

own-battery-proof: setup-dev ## fits of made measurements, 100 draws a battery: do 95 % intervals hold the truth? half an hour
	$(BIN)/python -m tests.experiments.own_battery.proof --draws 100

validate: setup ## hold the engine against closed forms, the first law, PyBaMM and ngspice (these two where installed)
	$(BIN)/python -m pipeline validate --cores $(CORES)

reproduce: setup ## run every study cold in a fresh folder and hold it against reproducibility/expected.json
	$(BIN)/python -m pipeline reproduce

reproduce-generic: setup ## the same as another CPU would: numbers within their tolerances, verdicts
	$(BIN)/python -m pipeline reproduce --generic

expected: setup ## renew reproducibility/expected.json; its diff reads as numbers
	$(BIN)/python -m pipeline reproduce --renew

accuracy: setup-dev ## the charge engine against a tight solve_ivp, three windows of 60 s
	$(BIN)/python -m benchmarks.accuracy

docs: setup setup-docs ## build the documentation: site/index.html, read from the file system
	$(BIN)/python docs/generate.py
	.venv-docs/bin/mkdocs build --quiet --strict

setup: $(VENV)/.runtime ## virtual environment with the runtime packages
setup-dev: $(VENV)/.dev ## the same with the tools of development

$(VENV)/.runtime: requirements.lock pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

$(VENV)/.dev: $(VENV)/.runtime requirements-dev.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-dev.lock
	touch $@

setup-docs: .venv-docs/.made

.venv-docs/.made: requirements-docs.lock
	test -x .venv-docs/bin/python || $(PYTHON) -m venv .venv-docs
	.venv-docs/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-docs.lock
	touch $@

setup-slurm: .venv-slurm/.made ## .venv-slurm: the runtime packages and what submits to Slurm (docs/clusters.md)

.venv-slurm/.made: requirements.lock requirements-slurm.lock pyproject.toml
	test -x .venv-slurm/bin/python || $(PYTHON) -m venv .venv-slurm
	.venv-slurm/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	.venv-slurm/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r requirements-slurm.lock
	.venv-slurm/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

# Without resolving: botocore asks for an older python-dateutil than matplotlib, and works with that of requirements.lock.
setup-s3: .venv-s3/.made ## .venv-s3: the runtime packages, what reaches buckets, and a server of them for tests

.venv-s3/.made: requirements.lock requirements-s3.lock pyproject.toml
	test -x .venv-s3/bin/python || $(PYTHON) -m venv .venv-s3
	.venv-s3/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes \
		-r requirements.lock -r requirements-s3.lock
	.venv-s3/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

lock: ## renew the lock files (needs uv)
	uv pip compile --quiet --no-header --no-annotate --generate-hashes --python-version 3.11 \
		pyproject.toml --extra build -o requirements.lock
	# One file for every version: the others have to come to the same packages.
	for version in 3.12 3.13; do uv pip compile --quiet --no-header --no-annotate --generate-hashes \
		--python-version $$version -c requirements.lock pyproject.toml --extra build | cmp - requirements.lock || exit 1; done
	uv pip compile --quiet --no-header --no-annotate --generate-hashes --python-version 3.11 \
		pyproject.toml --extra build --extra dev -c requirements.lock -o requirements-dev.lock
	printf 'snakemake-executor-plugin-slurm\nsnakemake-executor-plugin-slurm-jobstep\n' | uv pip compile --quiet \
		--no-header --no-annotate --generate-hashes --python-version 3.11 --no-deps - -o requirements-slurm.lock

clean: ## remove what runs made; keeps the virtual environment
	chmod -R u+w results reports 2>/dev/null || true
	git clean -fdxq results reports .snakemake .cache

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/:/' | column -t -s:
