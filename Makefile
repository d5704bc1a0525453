# The two commands of the README. Each makes what it needs in a virtual environment of its own.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin

.PHONY: run test clean

run: $(VENV)/run
	$(BIN)/msma-launch deploy/arph.yaml

test: $(VENV)/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest

$(VENV)/bin/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "MSMA needs Python 3.11 or newer; this is %d.%d. Say which to use: make PYTHON=python3.11" % sys.version_info[:2])'
	$(PYTHON) -m venv $(VENV)

$(VENV)/run: pyproject.toml $(VENV)/bin/pip
	$(BIN)/pip install --quiet --editable '.[keys,plots]'
	@touch $@

$(VENV)/test: pyproject.toml $(VENV)/bin/pip
	$(BIN)/pip install --quiet --editable '.[keys,plots,test]'
	@touch $@ $(VENV)/run

clean:
	rm -rf $(VENV) build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
