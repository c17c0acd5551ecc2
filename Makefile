# One file, Python 3.11+, git and make: every target sets up what it needs.
#
#   make demo    a worked example, results in out/demo
#   make check   style, types, direction of imports
#   make test    the tests
#   make test-browser  the front end: types, tests, its committed build, pages in a browser (needs Node, Chromium)
#   make docs    the documentation, in docs/_build/html
#   make bench   the measurements of docs/performance.md, which takes about an hour
#   make bench-browser  how long the pages take
#   make setup   only the virtual environment
#   make clean   remove everything that can be made again

VENV := .venv
ifeq ($(OS),Windows_NT)
PYTHON ?= python
BIN := $(VENV)/Scripts
else
PYTHON ?= python3
BIN := $(VENV)/bin
endif
STAMP := $(VENV)/installed
SOURCES := src tests $(wildcard benchmarks examples) $(wildcard docs/*.py) docs/notebooks

.DEFAULT_GOAL := help
.PHONY: help setup check test test-browser docs demo bench bench-browser clean

help:
	@echo "targets: setup check test test-browser docs demo bench bench-browser clean"

setup: $(STAMP)

# Made again when what it was made from has changed.
$(STAMP): pyproject.toml constraints.txt
	@echo "Setting up $(VENV) (about a minute)"
	@$(PYTHON) -c "import sys; sys.exit(None if sys.version_info >= (3, 11) else 'propermodel needs Python 3.11 or later; choose one with: make PYTHON=...')"
	@$(PYTHON) -c "import ensurepip, venv" || (echo "This Python cannot make virtual environments (on Debian: install python3-venv)"; exit 1)
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --no-input --disable-pip-version-check -e ".[dev]" -c constraints.txt
	@$(BIN)/python -c "import pathlib; pathlib.Path('$(STAMP)').touch()"

check: $(STAMP)
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/basedpyright
	$(BIN)/lint-imports

test: $(STAMP)
	$(BIN)/python -m pytest --numprocesses auto --dist worksteal

# Users need no Node: what is built is committed, and must be what its sources give.
test-browser: $(STAMP)
	cd web && npm ci --no-audit --no-fund && npm run check && npm run test && npm run build
	git diff --exit-code --stat -- src/propermodel/drawing/assets src/propermodel/report/assets src/propermodel/studio/assets
	$(BIN)/python -m tests.browser.wheel
	$(BIN)/python -m tests.browser.pages
	$(BIN)/python -m tests.browser.studio
	cd web && npm run browser

# What the pages take of a reader's time: figures, which depend on the machine.
bench-browser: $(STAMP)
	cd web && npm ci --no-audit --no-fund
	$(BIN)/python -m tests.browser.wheel
	$(BIN)/python -m tests.browser.pages
	$(BIN)/python -m tests.browser.studio
	cd web && npm run bench

docs: $(STAMP)
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html

demo: $(STAMP)
	$(BIN)/propermodel demo --out out/demo

bench: $(STAMP)
	$(BIN)/python -m benchmarks

clean:
	$(PYTHON) -c "import shutil; [shutil.rmtree(name, ignore_errors=True) for name in ('$(VENV)', 'out', 'docs/_build', 'docs/gallery', 'build', 'dist', '.pytest_cache', '.ruff_cache', '.hypothesis', '.import_linter_cache')]"
