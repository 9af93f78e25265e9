# Everything happens in .venv, which any target makes when it is missing.

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
DEV := $(VENV)/.ready-dev

# The first of these that is at least 3.12. `make PYTHON=/path/to/python` sets
# another.
CANDIDATES := python3 python3.12 python3.13 python3.14 python
CHECK := import sys; sys.exit(sys.version_info < (3, 12))

INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check

# Processes that tests start need not compile the code of those before them.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
.PHONY: help demo test test-all test-lowest coverage lint types docs notebook bench clean

help:
	@echo "make demo      run the Passing scenario, print the metrics, write a replay"
	@echo "make test      run the fast tests"
	@echo "make test-all  lint, types, and the slow tests: notebooks, the built wheel"
	@echo "make test-lowest  the fast tests with the oldest dependencies allowed"
	@echo "make coverage  how much of the code the fast tests run, by branches"
	@echo "make lint      check and format-check the code"
	@echo "make docs      build the docs site into out/docs"
	@echo "make notebook  open the notebooks in JupyterLab"
	@echo "make bench     measure speed"
	@echo "make clean     remove the environment and everything built"

# Only a changed pyproject.toml, or another Python, installs again.
$(READY): pyproject.toml .python-version
	@python="$(PYTHON)"; found=""; \
	if [ -z "$$python" ]; then for c in $(CANDIDATES); do \
	    version=$$($$c -c 'import platform; print(platform.python_version())' 2>/dev/null) || continue; \
	    if $$c -c '$(CHECK)' 2>/dev/null; then python=$$c; break; fi; \
	    found="$$found $$c is $$version;"; \
	done; fi; \
	if [ -z "$$python" ]; then \
	    echo "hunav_drake needs Python 3.12 or newer, found:$${found:- none}"; \
	    echo "Install one (python.org, uv, pyenv), or run: make PYTHON=/path/to/python3.12 ..."; \
	    exit 1; \
	fi; \
	if ! $$python -c '$(CHECK)' 2>/dev/null; then \
	    echo "hunav_drake needs Python 3.12 or newer, but PYTHON=$$python is not."; exit 1; \
	fi; \
	if ! $(BIN)/python -c '$(CHECK)' 2>/dev/null; then \
	    echo "Creating $(VENV) with $$($$python --version)"; \
	    rm -rf $(VENV) && $$python -m venv $(VENV) || { \
	    echo "Could not create $(VENV): on Debian and Ubuntu, install python3-venv."; exit 1; }; \
	fi
	@echo "Installing hunav_drake and what it needs (about 0.8 GB, a minute or two)"
	@$(INSTALL) --editable .
	@touch $@

$(DEV): $(READY)
	@echo "Installing what the tests, the notebooks and the docs need, too"
	@$(INSTALL) --editable '.[dev]'
	@touch $@

demo: $(READY)
	@rm -rf out/demo
	@$(BIN)/hunav run passing --out out/demo

test: $(DEV)
	@$(BIN)/python -m pytest -m "not slow" -n 2 --dist worksteal

test-all: $(DEV) lint types
	@$(BIN)/python -m pytest -n 2 --dist worksteal -m slow

# With the oldest versions that pyproject.toml allows of what users install, in
# an environment of its own. (What runs the tests is new.)
LOWEST := $(VENV)-lowest

$(LOWEST)/.ready: pyproject.toml tests/lowest.py $(READY)
	@rm -rf $(LOWEST)
	@$(BIN)/python -m venv $(LOWEST)
	@$(BIN)/python -m tests.lowest > $(LOWEST)/constraints.txt
	@echo "Installing the oldest versions that are allowed"
	@$(LOWEST)/bin/python -m pip install --quiet --disable-pip-version-check \
	    --constraint $(LOWEST)/constraints.txt --only-binary :all: \
	    --editable '.[completion,dask,editor,falsify,film]' \
	    hypothesis jsonschema nbclient py_trees pytest pytest-xdist
	@touch $@

# Its kernels are kept apart, for another numba reads none that are not its own.
test-lowest: $(LOWEST)/.ready
	@rm -rf $(LOWEST)/kernels
	@NUMBA_CACHE_DIR=$(CURDIR)/$(LOWEST)/kernels $(LOWEST)/bin/python -m pytest \
	    -m "not slow" -p no:cacheprovider -n 2

coverage: $(DEV)
	@COVERAGE_CORE=ctrace $(BIN)/python -m pytest -m "not slow" -n 2 --dist worksteal --cov --cov-branch --cov-report=term --cov-report=html:out/coverage/html

lint: $(DEV)
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .

types: $(DEV)
	@$(BIN)/mypy

docs: $(DEV)
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "The docs, for a browser: out/docs/index.html"

notebook: $(READY)
	@$(INSTALL) --editable '.[notebook]'
	@$(BIN)/jupyter lab notebooks

bench: $(DEV)
	@$(BIN)/python -m tests.benchmarks

clean:
	rm -rf $(VENV) $(LOWEST) build dist out *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
