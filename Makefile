# Needs GNU make, Python 3.11 or later and a package index. Every target makes .venv on first use.
PYTHON ?= python3
# pytest-xdist workers; 0 runs the tests in one process
JOBS ?= auto
PYTEST_ARGS ?=
# arguments of the benchmark, such as --quick
BENCH_ARGS ?=

# a kernel that the environment forces upon OpenBLAS would lower the peak that shares are measured by
NATIVE_BLAS := env -u OPENBLAS_CORETYPE -u OPENBLAS_L2_SIZE

VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
PEERS := $(VENV)/.peers

.DEFAULT_GOAL := help
.PHONY: help install test test-slow test-lowest check docs docs-figures reproduce gallery house bench bench-studies bench-chain bench-quality

help: ## show this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 16

install: $(INSTALLED) ## make .venv with the project (editable) and its development tools

# The stamp is newer than pyproject.toml only if the last installation went through.
$(INSTALLED): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or later is needed, PYTHON=... names it" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

test: $(INSTALLED) ## run the tests, under five minutes on two cores
	$(BIN)/python -m pytest -n $(JOBS) -m 'not slow' $(PYTEST_ARGS)

test-slow: $(INSTALLED) ## run the long tests, as CI does
	$(BIN)/python -m pytest -n $(JOBS) -m slow $(PYTEST_ARGS)

# Every dependency in the lowest version that pyproject.toml allows, in an environment of its own. Beside the newest of
# what they need in turn, old versions use what is deprecated there; that is no error of ours, nor is matplotlib's use of
# names that pyparsing 3.3 deprecates.
LOWEST := .venv-lowest
$(LOWEST)/.installed: pyproject.toml
	$(PYTHON) -m venv $(LOWEST)
	$(PYTHON) -c 'import tomllib; p = tomllib.load(open("pyproject.toml", "rb"))["project"]; \
	  print(*(d.replace(">=", "==") for d in p["dependencies"] + p["optional-dependencies"]["cluster"]), "pyparsing<3.3", sep="\n")' \
	  > $(LOWEST)/constraints.txt
	$(LOWEST)/bin/python -m pip install --quiet --disable-pip-version-check --editable '.[test,cluster]' \
	  --constraint $(LOWEST)/constraints.txt
	@touch $@

test-lowest: $(LOWEST)/.installed ## run the tests with the lowest versions that pyproject.toml allows
	NUMBA_CACHE_DIR=$(CURDIR)/$(LOWEST)/compiled $(LOWEST)/bin/python -m pytest -n $(JOBS) -m 'not slow' \
	  -W default::DeprecationWarning -W default::PendingDeprecationWarning $(PYTEST_ARGS)

check: $(INSTALLED) ## ruff, formatting, types, layers of the packages, scientific-python review
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/repo-review . --show err

# A page that is left over from an earlier build would hide a broken link.
docs: $(INSTALLED) ## build the documentation into docs/_build/html, a warning is an error
	rm -rf docs/_build
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html

docs-figures: $(INSTALLED) ## draw the figures of the tutorial anew, by following it
	$(BIN)/python -m tests.draw_tutorial docs/figures

reproduce: $(INSTALLED) ## repeat the experiment of Mauelshagen 1980 into results/mauelshagen-1980
	$(BIN)/simfield reproduce mauelshagen-1980
	$(BIN)/simfield report results/mauelshagen-1980

gallery: $(INSTALLED) ## draw every kind of figure into docs/gallery, and the picture of the front page
	$(BIN)/python -m studies.gallery docs

house: $(INSTALLED) ## draw the rooms as they stand: docs/house.md and its picture
	$(BIN)/python -m tests.draw_house

# Other solvers are needed for comparison only.
$(PEERS): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[bench]'
	@touch $@

bench: $(PEERS) ## this engine beside scipy, GTSAM and Ceres; writes benchmarks/latest.json
	$(NATIVE_BLAS) $(BIN)/python -m benchmarks.bench $(BENCH_ARGS)

bench-studies: $(INSTALLED) ## what a study costs on top of its adjustments, and dask on top of joblib
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[cluster]'
	$(NATIVE_BLAS) $(BIN)/python -m benchmarks.studies --output benchmarks/latest_studies.json
	$(BIN)/python -m benchmarks.cluster --output benchmarks/latest_cluster.json

bench-chain: $(INSTALLED) ## what the measurement chain costs beside the adjustment; writes benchmarks/chain.json
	$(NATIVE_BLAS) $(BIN)/python -m benchmarks.chain $(BENCH_ARGS)

bench-quality: $(INSTALLED) ## what reliability and the protocol cost; writes benchmarks/quality.json
	$(NATIVE_BLAS) $(BIN)/python -m benchmarks.quality $(BENCH_ARGS)
