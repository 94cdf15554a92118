PYTHON ?= python3
CORES ?= 2

ifneq ($(words $(CURDIR)),1)
$(error Snakemake does not work in an environment whose path has a blank. Move this folder)
endif

VENV := .venv
BIN := $(CURDIR)/$(VENV)/bin
# An environment contains its path, so it is made again after a move of the folder.
OTHERS := test -f $(VENV)/pyvenv.cfg && test ! -L $(VENV) && ! grep -qF '$(CURDIR)/' $(VENV)/pyvenv.cfg
MOVED := $(shell $(OTHERS) && echo moved)
LOCK := envs/requirements.lock
# Stamps of the locked packages and of the package itself: a changed lock rebuilds the environment,
# so that it only contains the lock; a changed pyproject.toml only reinstalls the package.
PINNED := $(VENV)/.pinned
INSTALLED := $(VENV)/.installed

# The lock is complete, so no other package is installed.
LOCKED := $(BIN)/python -m pip install --quiet --require-hashes --no-deps
TORCH := $(shell grep -o '^torch==[^ ]*' $(LOCK))

# The interpreter behind $(PYTHON), which may be a link in the environment that is rebuilt.
REAL := import os, sys; print(os.path.realpath(sys.executable))

# Rules and tests that start `python` or `snakemake` use the environment's.
export PATH := $(BIN):$(value PATH)
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: help all test test-all test-browser test-faults test-slurm test-pythons lint format environment numbers defaults ship dist site lock clean distclean moved
.DELETE_ON_ERROR:

help:
	@echo "make all          environment, then the whole workflow on $(CORES) cores (CORES=...)"
	@echo "make test         environment, lint, unit tests, the whole workflow at a small size"
	@echo "make test-all     the same, with sweeps, deployments and all dry runs of the workflow"
	@echo "make test-faults  100,000 damaged files before the reader, half an hour of two cores"
	@echo "make test-browser the page of breaker view in Chromium (apt install chromium chromium-driver)"
	@echo "make test-slurm   the whole workflow at a small size through a Slurm of this machine"
	@echo "make test-pythons the instrument under each of Python 3.11 to 3.14 that is here"
	@echo "make lint         the lint of make test alone"
	@echo "make format       format Python and Snakemake files in place"
	@echo "make environment  $(VENV) from $(LOCK), with $(PYTHON) (PYTHON=...)"
	@echo "make numbers      write the numbers of the last run into README.md and docs/, with its pictures"
	@echo "make pictures     draw the pictures of docs/ from the data in docs/pictures.json"
	@echo "make defaults     write config/, the schema of the settings, and docs/reference/ from the code"
	@echo "make ship         put the models of the last run, which is that of the defaults, into the package"
	@echo "make dist         wheel and source distribution in dist/, checked and used in a bare environment"
	@echo "make site         documentation in build/site/html, its links checked, in an environment of its own"
	@echo "make lock         pin the newest versions that pyproject.toml allows in envs/"
	@echo "make clean        remove what the workflow made: results, figures, logs"
	@echo "make distclean    clean, and remove the environment and all caches"

all: $(INSTALLED)
	@echo "== workflow: snakemake -c$(CORES) all"
	$(BIN)/snakemake -c$(CORES) all
	@echo "== done: look at figures/, or make a report: $(BIN)/snakemake --report report.html"

test: lint
	@echo "== tests, whole files side by side; the first is the whole workflow with config/test.yaml"
	$(BIN)/python -m pytest -n $(CORES) --dist loadfile --no-loadscope-reorder

test-all: lint
	@echo "== all tests, the slow ones too"
	$(BIN)/python -m pytest -n $(CORES) --dist loadfile --no-loadscope-reorder -m ""

test-faults: $(INSTALLED)
	@echo "== damaged files before the reader: results/faults.csv, half an hour of two cores"
	$(BIN)/python -m studies.faults --table results/faults.csv --cores $(CORES)

test-browser: $(INSTALLED)
	@echo "== breaker view in Chromium: pictures in build/browser/, to be looked at"
	$(LOCKED) --target build/axe --upgrade --requirement envs/axe.lock
	$(BIN)/python -m tests.browser.walk

# The plugin is outside the environment, which only contains its lock.
test-slurm: $(INSTALLED)
	@echo "== the small workflow through a Slurm of this machine"
	$(LOCKED) --target build/slurm --upgrade --requirement envs/slurm.lock
	PYTHONPATH="$$PWD/build/slurm" tests/slurm/run.sh

test-pythons: $(INSTALLED)
	@echo "== the instrument, without torch and Snakemake, under other versions of Python"
	$(BIN)/python envs/pythons.py

lint: $(INSTALLED)
	@echo "== lint: ruff, import-linter, snakefmt, snakemake --lint"
	$(BIN)/ruff check .
	$(BIN)/lint-imports --no-cache
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint
	$(BIN)/python docs/style.py

format: $(INSTALLED)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt Snakefile workflow

environment: $(INSTALLED)
	@echo "== the environment is ready: source $(VENV)/bin/activate"

$(INSTALLED): pyproject.toml $(PINNED)
	@echo "== installing the package breaker into $(VENV)"
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

$(PINNED): $(LOCK) $(MOVED)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "breaker needs Python 3.11 or newer; '$(PYTHON)' is not one." >&2; \
	  echo "Install one and name it, for example: make PYTHON=python3.12 all" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "'$(PYTHON)' cannot make virtual environments: its module venv is missing." >&2; \
	  echo "On Debian and Ubuntu: apt install python3-venv" >&2; exit 1; }
	@echo "== making $(VENV) from $(LOCK) (a few minutes, only when the lock has changed)"
	base=$$($(PYTHON) -c '$(REAL)') && "$$base" -m venv --clear $(CURDIR)/$(VENV)
	@# setuptools builds the few packages without wheels, so that pip fetches no other version.
	awk '/^setuptools==/,!/\\$$/' $(LOCK) | $(LOCKED) --requirement /dev/stdin
	@# A wheel of torch in a folder of pip's setting find-links is installed unchecked. Such a wheel,
	@# mostly for the CPU only, differs between machines, so no lock can contain its hash. Without
	@# such a wheel, torch comes from the lock.
	$(BIN)/python -m pip install --quiet --no-index --no-deps $(TORCH) 2>/dev/null || true
	$(LOCKED) --no-build-isolation --use-pep517 --requirement $(LOCK)
	@# On Linux, the lock's torch needs gigabytes of packages that it pins itself; elsewhere none.
	$(BIN)/python -m pip install --quiet $(TORCH)
	@touch $@

numbers: $(INSTALLED)
	cp results/numbers.csv docs/numbers.csv
	$(BIN)/python docs/restate.py
	$(BIN)/python docs/tables.py
	$(BIN)/python docs/pictures.py results

pictures: $(INSTALLED)
	$(BIN)/python docs/pictures.py

defaults: $(INSTALLED)
	$(BIN)/python envs/defaults.py
	$(BIN)/python docs/reference.py

ship: $(INSTALLED)
	$(BIN)/python envs/ship.py

dist: $(INSTALLED)
	$(BIN)/python envs/wheel_check.py

build/site-env/.pinned: envs/site.lock
	$(PYTHON) -m venv --clear build/site-env
	build/site-env/bin/python -m pip install --quiet --require-hashes --no-deps --requirement $<
	@touch $@

site: build/site-env/.pinned
	build/site-env/bin/python envs/site.py
	NO_MKDOCS_2_WARNING=1 build/site-env/bin/mkdocs build --quiet --strict
	@echo "== open build/site/html/index.html"

lock: $(INSTALLED)
	@echo "== pinning the newest versions that pyproject.toml allows"
	$(BIN)/python -m pip install --upgrade --upgrade-strategy eager --editable '.[slurm,test]' setuptools uv
	$(BIN)/python envs/lock.py
	@echo "== envs/ is renewed: look at the differences, run make test, commit"

clean:
	rm -rf results figures logs checkpoints paper report.html report.zip

distclean: clean
	rm -rf $(VENV) .snakemake .pytest_cache .ruff_cache build dist src/*.egg-info
	find src studies tests workflow envs -name __pycache__ -type d -prune -exec rm -rf {} +
