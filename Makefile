# make heater: install and run the main example.   make test: install and test.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# what gmsh's wheel needs to mesh a .geo, and what compiles the UFL forms; both are optional
SYSTEM := libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1 gcc libc6-dev python3-dev

.PHONY: heater test test-slow system lint clean

heater: $(BIN)/contbed
	$(BIN)/contbed run studies/moving_bed_heater/heater.toml --out results/heater

test: system $(VENV)/.test
	$(BIN)/python -m pytest -q -n auto

test-slow: system $(VENV)/.test
	$(BIN)/python -m pytest -q -n auto -m slow

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/mypy

$(BIN)/contbed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	@touch $@

$(VENV)/.test: $(BIN)/contbed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test,dev]'
	@touch $@

# root on Debian or Ubuntu gets the system packages; anyone else is told, and the tests that need them are skipped by name
system:
	@if command -v dpkg >/dev/null && ! dpkg -s $(SYSTEM) >/dev/null 2>&1; then \
	  if [ "$$(id -u)" = 0 ]; then apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qqy install --no-install-recommends $(SYSTEM) >/dev/null; \
	  else echo "optional system packages are missing: sudo apt-get install $(SYSTEM)"; fi; fi

clean:
	rm -rf $(VENV) build *.egg-info results
