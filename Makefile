# `make` or `make help` lists the commands. `make book` and `make test` need python3.11 or later (with venv), make and a C
# compiler.

SHELL       := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS   += --no-print-directory
.DELETE_ON_ERROR:

PYTHON ?= python3
VENV   ?= .venv
PORT   ?= 8000
STUDY  ?=
NETWORK ?=

# Relative folders are kept relative; every command of the environment is reached through it, nothing is activated.
IN      := $(VENV)/bin
READY   := $(VENV)/.installed
HTML    := _build/html
CACHE   := _build/.jupyter_cache
LOG     := _build/book.log

# Chapters run with the environment's own kernel and without the user's IPython profile or packages.
export PYTHONNOUSERSITE        := 1
export JUPYTER_PREFER_ENV_PATH := 1
export JUPYTER_PLATFORM_DIRS   := 1
export IPYTHONDIR              := $(abspath $(VENV))/ipython

.PHONY: help book test lint check full networks bench serve lock clean distclean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

# ---- the environment: made once, and again when the lock or pyproject.toml changes ----

$(READY): environment.lock pyproject.toml
	@rm -f $@
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and f"{sys.executable} is Python {sys.version.split()[0]}; 3.11 or later is needed: make PYTHON=python3.11 ...")'
	@echo "Setting up $(VENV) from environment.lock (once; minutes, depending on the connection)"
	@$(PYTHON) -m venv $(VENV)
	@$(IN)/python -m pip install --disable-pip-version-check --no-input --progress-bar off -r environment.lock \
	  | awk -v all="$$(grep -c '==' environment.lock)" \
	    '/^Collecting |^Requirement already/ { if (++seen % 25 == 0 && seen <= all) print "  " seen " of " all " packages fetched" } \
	     /^Installing collected/ { print "  installing" } { fflush() }'
	@$(IN)/python -m pip install --disable-pip-version-check --no-input --quiet --no-deps --no-build-isolation -e .
	@touch $@

# ---- the book ----

# Sphinx takes a page that it has read before for up to date, so its own memory goes when the executed cells have gone,
# and after a failed build, whose warnings it would not repeat.
book: $(READY)  ## build the book into _build/html
	@$(IN)/python -c "from dexterity.scenes import copy_viewer; copy_viewer('book/assets/meshcat')"
	@$(IN)/python -m dexterity.report.provenance fresh-cache $(CACHE)
	@[ -e $(CACHE)/global.db ] || rm -rf _build/.doctrees
	@$(IN)/jupyter-book build book --config _config.yml --path-output . -W --keep-going 2>&1 | tee $(LOG) || { \
	  rm -rf _build/.doctrees; \
	  echo "---- The book was not built, because of:"; \
	  awk '/WARNING:|ERROR:|^(Extension|Configuration) error/ { print } /^nbclient.*Error:/ { cell = 1 } cell { print } /^The above exception/ { cell = 0 }' $(LOG) | tail -n 60; \
	  exit 1; }
	@echo "The book: file://$(CURDIR)/$(HTML)/index.html"

serve:  ## serve the built book on 127.0.0.1 (PORT=8000)
	@[ -e $(HTML)/index.html ] || { echo "There is no built book yet: make book"; exit 1; }
	@$(PYTHON) -m http.server $(PORT) --bind 127.0.0.1 --directory $(HTML)

# ---- checks ----

test: $(READY)  ## run the tests
	@$(IN)/python -m pytest tests --ignore=tests/book --ignore=tests/benchmarks --numprocesses auto --dist loadfile

check: book  ## check verdicts, stored results, and the built book in a real browser
	@$(IN)/python -m dexterity.studies probe
	@$(IN)/python -m dexterity.studies check
	@$(IN)/python -m pytest tests/book

lint: $(READY)  ## style, types, layers, lock
	$(IN)/ruff check src tests
	$(IN)/ruff format --check src tests
	$(IN)/mypy
	$(IN)/lint-imports
	@if grep -nE '^(nvidia|triton|cuda)' environment.lock; then \
	  echo "environment.lock has CUDA packages: make it with make lock"; exit 1; \
	  else echo "environment.lock: no CUDA packages"; fi

bench: $(READY)  ## run the benchmarks, print their ratios, write them into _build/benchmarks
	@$(IN)/python -m pytest -s tests/benchmarks

# ---- long runs, lock, cleaning ----

full: $(READY)  ## run studies at full scale and store their results (STUDY=uvms.kinematics for one)
	@$(IN)/python -m dexterity.studies full $(STUDY)

networks: $(READY)  ## train, choose and judge the networks in data/networks (NETWORK=uvms-manipulability-feed-forward for one)
	@$(IN)/python -m dexterity_study.shipment $(NETWORK)

# torch's metadata names CUDA packages for Linux. They are no part of the lock: with a CPU build of torch they are not
# needed, and with the registry's build pip adds the ones that it names.
lock:  ## compile environment.lock from environment.in
	@mkdir -p _build
	@$(PYTHON) -m venv _build/uv
	@_build/uv/bin/python -m pip install --disable-pip-version-check --no-input --quiet uv
	@_build/uv/bin/uv pip compile environment.in --quiet --no-annotate --no-header \
	  --python-version 3.11 --python-platform x86_64-manylinux_2_28 --output-file _build/resolved.txt --upgrade
	@{ echo "# Made by make lock from environment.in, for Python 3.11 on Linux x86_64. The CUDA packages of torch are left"; \
	   echo "# out on purpose: a CPU build needs none, and with the registry's build pip resolves them by itself."; \
	   grep -vE '^(nvidia|triton|cuda)' _build/resolved.txt; } > environment.lock.new
	@mv environment.lock.new environment.lock

clean:  ## remove what make book and the tools made, keep .venv and remembered results
	@rm -rf _build book/assets/meshcat dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	@find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean  ## remove .venv and remembered results too
	@rm -rf $(VENV) .results
