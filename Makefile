# `make` or `make help` lists the commands. `make book` and `make test` need python3.11 or later (with venv), make and a C
# compiler.

# What make has started ends with make, even with one that was killed. (Kernels and workers end with what started them.)
ifeq ($(shell setpriv --pdeathsig KILL true 2>/dev/null && echo yes),yes)
ENDS_WITH_PARENT := setpriv --pdeathsig KILL
SHELL       := $(shell command -v setpriv)
.SHELLFLAGS := --pdeathsig KILL /bin/bash -eu -o pipefail -c
else
ENDS_WITH_PARENT :=
SHELL       := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
endif
.DEFAULT_GOAL := help
MAKEFLAGS   += --no-print-directory
.DELETE_ON_ERROR:

PYTHON ?= python3
VENV   ?= .venv
PORT   ?= 8000
NETWORK ?=
CH     ?=
T      ?=
PART   ?=
REASON ?=
SMOKE  ?=
BACKEND ?=
SCHEDULER ?=
UPGRADE ?=

# Relative folders are kept relative; every command of the environment is reached through it, nothing is activated.
IN   := $(VENV)/bin
HTML := _build/html

# What the environment holds: what the book needs, or all of environment.lock.
BOOK_ENV := $(VENV)/.book
FULL_ENV := $(VENV)/.all

# Chapters run with the environment's own kernel and without the user's IPython profile or packages.
export PYTHONNOUSERSITE        := 1
export JUPYTER_PREFER_ENV_PATH := 1
export JUPYTER_PLATFORM_DIRS   := 1
export IPYTHONDIR              := $(abspath $(VENV))/ipython
# The packages of this tree, whatever tree the environment was made for: it may be a link or a copy.
export PYTHONPATH              := $(CURDIR)/src
# Packages are compiled when they are first imported, and kept so: some machines are told not to keep them.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: help book chapter test lint check evidence stale accept networks bench serve lock clean distclean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

# ---- the environment: made once, and again when the lock or pyproject.toml changes ----

INSTALL := $(ENDS_WITH_PARENT) $(IN)/python -m pip --disable-pip-version-check --no-input install --no-compile --progress-bar off
# Of pip's many lines, one for every 25 packages.
COUNTED := awk '/^Collecting |^Requirement already/ { if (++seen % 25 == 0) print "  " seen " packages" } /^Installing coll/ { print "  installing" } { fflush() }'

# Two that set up one environment wait for each other.
ONE_AT_A_TIME := if command -v flock > /dev/null; then flock 9; fi

$(BOOK_ENV): environment.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and f"{sys.executable} is Python {sys.version.split()[0]}; 3.11 or later is needed: make PYTHON=python3.11 ...")'
	@mkdir -p $(VENV); exec 9< $(VENV); $(ONE_AT_A_TIME); if [ $@ -nt environment.lock ] && [ $@ -nt pyproject.toml ]; then exit 0; fi; \
	rm -f $(BOOK_ENV) $(FULL_ENV); \
	echo "Setting up $(VENV) for the book (once; minutes, depending on the connection)"; \
	$(PYTHON) -m venv $(VENV); \
	$(INSTALL) --quiet --constraint environment.lock hatchling editables; \
	$(INSTALL) --constraint environment.lock --no-build-isolation --editable '.[book]' | $(COUNTED); \
	touch $@

$(FULL_ENV): $(BOOK_ENV)
	@exec 9< $(VENV); $(ONE_AT_A_TIME); if [ $@ -nt $(BOOK_ENV) ]; then exit 0; fi; \
	echo "Adding to $(VENV) what tests and checks need (once)"; \
	$(INSTALL) --requirement environment.lock | $(COUNTED); \
	touch $@

# ---- the book ----

book: $(BOOK_ENV)  ## build the book into _build/html
	@$(IN)/python -m dexterity_study.page.build

chapter: $(BOOK_ENV)  ## build one page of the book (CH=uvms/kinematics)
	@[ -n "$(CH)" ] || { echo "Which page? For example: make chapter CH=uvms/kinematics"; exit 1; }
	@$(IN)/python -m dexterity_study.page.build $(CH)

serve:  ## serve the built book on 127.0.0.1 (PORT=8000)
	@[ -e $(HTML)/index.html ] || { echo "There is no built book yet: make book"; exit 1; }
	@$(PYTHON) -m http.server $(PORT) --bind 127.0.0.1 --directory $(HTML)

# ---- checks ----

test: $(FULL_ENV)  ## run the tests (T=tests/test_chain.py for some)
	@$(IN)/python -m pytest $(or $(T),tests --ignore=tests/book --ignore=tests/benchmarks --numprocesses auto --dist loadfile --no-loadscope-reorder)

check: $(FULL_ENV) book  ## check verdicts, stored results, and the built book in a real browser
	@$(EVIDENCE) probe
	@$(IN)/python -m dexterity_study.claims.check
	@$(IN)/python -m pytest tests/book/test_instruments.py
	@$(IN)/python -m pytest tests/book --ignore tests/book/test_instruments.py --numprocesses auto
	@cat _build/reading.txt

lint: $(FULL_ENV)  ## style, types, layers, lock
	$(IN)/ruff check src tests
	$(IN)/ruff format --check src tests
	$(IN)/mypy
	$(IN)/lint-imports
	$(IN)/python -m dexterity_study.page.prose book README.md
	@if grep -nE '^(nvidia|triton|cuda)' environment.lock; then \
	  echo "environment.lock has CUDA packages: make it with make lock"; exit 1; \
	  else echo "environment.lock: no CUDA packages"; fi

bench: $(FULL_ENV)  ## run the benchmarks, print their ratios, write them into _build/benchmarks
	@$(IN)/python -m pytest -s tests/benchmarks

# ---- evidence ----

EVIDENCE := $(IN)/python -m dexterity_study.engine.command

evidence: $(FULL_ENV)  ## run what is out of date and store it (PART=uvms.cost; SMOKE=1 to try it; BACKEND=dask SCHEDULER=tcp://...)
	@$(EVIDENCE) $(if $(SMOKE),smoke $(PART),evidence $(PART) --backend $(or $(BACKEND),loky) --scheduler '$(SCHEDULER)')

stale: $(FULL_ENV)  ## list what is out of date, and why, per file (PART=uvms.cost)
	@$(EVIDENCE) stale $(PART)

accept: $(FULL_ENV)  ## repeat probes, and accept runs although files have changed (PART=uvms.cost REASON="...")
	@$(EVIDENCE) accept $(PART) --reason '$(REASON)'

networks: $(FULL_ENV)  ## train, choose and judge the networks in data/networks (NETWORK=uvms-manipulability-feed-forward for one)
	@$(IN)/python -m dexterity_study.shipment $(NETWORK)

# ---- lock, cleaning ----

# Pins that still fit stay; UPGRADE=--upgrade renews all. torch's metadata names CUDA packages for Linux. They are no part
# of the lock: with a CPU build of torch they are not needed, and with the registry's build pip adds the ones that it names.
lock:  ## compile environment.lock from environment.in (UPGRADE=--upgrade renews all pins)
	@mkdir -p _build
	@$(PYTHON) -m venv _build/uv
	@_build/uv/bin/python -m pip install --disable-pip-version-check --no-input --quiet uv
	@cp environment.lock _build/resolved.txt
	@_build/uv/bin/uv pip compile environment.in --quiet --no-annotate --no-header \
	  --python-version 3.11 --python-platform x86_64-manylinux_2_28 --output-file _build/resolved.txt $(UPGRADE)
	@{ echo "# Made by make lock from environment.in, for Python 3.11 on Linux x86_64. The CUDA packages of torch are left"; \
	   echo "# out on purpose: a CPU build needs none, and with the registry's build pip resolves them by itself."; \
	   grep -vE '^(#|nvidia|triton|cuda)' _build/resolved.txt; } > environment.lock.new
	@mv environment.lock.new environment.lock

clean:  ## remove what make book and the tools made, keep .venv
	@if [ -d _build ] && command -v flock > /dev/null && ! flock --nonblock _build true; then \
	  echo "Another process works in _build: wait until it has ended, or stop it"; exit 1; fi
	@rm -rf _build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	@find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean  ## remove .venv too
	@rm -rf $(VENV)
