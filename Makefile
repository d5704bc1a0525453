# The two commands of the README. Each installs what it needs in a virtual environment.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin

.PHONY: run test clean

# On a terminal it also opens the page from which a person drives the robot, and goes on until Ctrl-C;
# elsewhere, or with `make run RUN=task`, it ends with the paper's task.
DEPLOYMENT = $(if $(and $(MAKE_TERMOUT),$(filter-out task,$(or $(RUN),page))),arph-web,arph)

run: $(VENV)/run
	$(BIN)/msma-launch deploy/$(DEPLOYMENT).yaml

# Most tests wait for robots in real time, so several run at once: tests/conftest.py says how many.
test: $(VENV)/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest -n auto

$(VENV)/bin/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "MSMA needs Python 3.11 or newer; this is %d.%d. Say which to use: make PYTHON=python3.11" % sys.version_info[:2])'
	$(PYTHON) -m venv $(VENV)

# pip does not compile an editable installation, and some environments keep Python from doing so: then
# every process would compile all its imports again, and take a quarter longer to start.
COMPILE = $(BIN)/python -m compileall -q agents bench nodes plant runtime studies

# The tests of the operator's page need a browser; without one they are skipped, and say so.
CHROMIUM = command -v chromium >/dev/null || command -v chromium-browser >/dev/null || \
	if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		apt-get update -q && apt-get install -qy --no-install-recommends chromium; \
	else echo 'No Chromium: the tests of the page will be skipped'; fi

$(VENV)/run: pyproject.toml $(VENV)/bin/pip
	$(BIN)/pip install --quiet --editable '.[keys,plots,web]'
	$(COMPILE)
	@touch $@

$(VENV)/test: pyproject.toml $(VENV)/bin/pip
	$(BIN)/pip install --quiet --editable '.[keys,plots,web,test]'
	$(COMPILE)
	@$(CHROMIUM)
	@touch $@ $(VENV)/run

clean:
	rm -rf $(VENV) build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
