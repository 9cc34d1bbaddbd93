# make heater: install and run the main example.   make gallery: list the studies.   make test: install and test.   make test-dolfinx: the engine for MPI.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# what gmsh's wheel needs to mesh a .geo, and what compiles the UFL forms; both are optional
SYSTEM := libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1 gcc libc6-dev python3-dev

# the browser of Debian, for the test of the report
SYSTEM_BROWSER := chromium

# the engine for MPI comes from the system, with the system's Python and NumPy; its environment sees both
VENV_DOLFINX ?= .venv-dolfinx
SYSTEM_DOLFINX := python3-dolfinx mpi-default-bin python3-venv gcc libc6-dev python3-dev

# the wheel, apart from the files of the project
VENV_DIST ?= .venv-dist

# the lowest versions of the libraries that pyproject.toml declares; NumPy 1.24 needs Python 3.11
VENV_FLOORS ?= .venv-floors
PYTHON_FLOORS ?= python3.11
FLOORS := tests/unit tests/materials tests/closures/test_closure_values.py tests/stress/test_restart.py tests/dem/test_particle_scenes.py

# the files that codespell reads; tests misspell words on purpose
PROSE := contbed docs studies README.md CHANGELOG.md CONTRIBUTING.md CITATION.cff Makefile pyproject.toml

.PHONY: docs notebooks heater gallery test test-slow test-browser mutants test-floors test-dolfinx dolfinx dist lock system lint clean

heater: $(BIN)/contbed
	$(BIN)/contbed run studies/moving_bed_heater/heater.toml --out results/heater

# the manual in docs/_build/html; needs no network once its libraries are there, and warnings are errors
docs: $(VENV)/.docs
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "open docs/_build/html/index.html"

# the notebooks of the manual, each in a kernel of its own
notebooks: $(VENV)/.test
	$(BIN)/python -m pytest -q -m slow tests/docs/test_manual.py -k notebooks

$(VENV)/.docs: $(BIN)/contbed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	@touch $@

gallery: $(VENV)/.test
	$(BIN)/python -m studies

test: system $(VENV)/.test
	$(BIN)/python -m pytest -q -n auto --dist worksteal

test-slow: system $(VENV)/.test
	$(BIN)/python -m pytest -q -n auto -m slow

# the report in a browser without a screen; skipped by name where there is none
test-browser: $(VENV)/.report
	@if ! command -v $(SYSTEM_BROWSER) >/dev/null && [ "$$(id -u)" = 0 ]; then \
	  apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qqy install --no-install-recommends $(SYSTEM_BROWSER) >/dev/null || true; fi
	$(BIN)/python -m pytest -q -m slow tests/report/test_report.py -k browser

$(VENV)/.report: $(VENV)/.test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[report]'
	@touch $@

# breaks the package on purpose, line by line, and sees that a test fails
mutants: $(VENV)/.test
	$(BIN)/python tests/mutants.py

test-floors: $(VENV_FLOORS)/.test
	$(VENV_FLOORS)/bin/python -m pytest -q -n auto $(FLOORS)

$(VENV_FLOORS)/.test: pyproject.toml tests/floors.py
	$(PYTHON_FLOORS) -m venv $(VENV_FLOORS)
	$(VENV_FLOORS)/bin/python tests/floors.py > $(VENV_FLOORS)/floors.txt
	$(VENV_FLOORS)/bin/python -m pip install --quiet --disable-pip-version-check -c $(VENV_FLOORS)/floors.txt -e '.[test]'
	@touch $@

test-dolfinx: $(VENV_DOLFINX)/.test
	OMP_NUM_THREADS=1 $(VENV_DOLFINX)/bin/python -m pytest -q tests/ranks

dolfinx: $(VENV_DOLFINX)/.test

$(VENV_DOLFINX)/.test: pyproject.toml
	@if ! dpkg -s $(SYSTEM_DOLFINX) >/dev/null 2>&1; then \
	  if [ "$$(id -u)" = 0 ]; then apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qqy install --no-install-recommends $(SYSTEM_DOLFINX) >/dev/null; \
	  else echo "needed: sudo apt-get install $(SYSTEM_DOLFINX)"; exit 1; fi; fi
	/usr/bin/python3 -m venv --system-site-packages $(VENV_DOLFINX)
	/usr/bin/python3 -c "import numpy, scipy; print(f'numpy=={numpy.__version__}\nscipy=={scipy.__version__}')" > $(VENV_DOLFINX)/system.txt
	$(VENV_DOLFINX)/bin/python -m pip install --quiet --disable-pip-version-check -c $(VENV_DOLFINX)/system.txt -e . 'pytest>=8.2'
	@touch $@

# sdist and wheel in dist/; the wheel is built from the sdist and tried in a clean environment with the locked versions
dist: $(VENV)/.test
	rm -rf dist
	$(BIN)/python -m build --outdir dist .
	$(PYTHON) -m venv --clear $(VENV_DIST)
	$(VENV_DIST)/bin/python -m pip install --quiet --disable-pip-version-check -c requirements.lock dist/*.whl
	cd dist && $(abspath $(VENV_DIST))/bin/contbed --version
	cd dist && $(abspath $(VENV_DIST))/bin/contbed new packed_bed --out bed.toml
	cd dist && $(abspath $(VENV_DIST))/bin/contbed run bed.toml --out bed --quiet
	rm -rf dist/bed dist/bed.toml

lock: $(VENV)/.test
	echo "# Exact versions of a tested environment (Python 3.11, Linux); \`make lock\` writes them anew." > requirements.lock
	$(BIN)/python -m pip freeze --all --exclude-editable --exclude contbed --exclude pip >> requirements.lock

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/codespell $(PROSE)

$(BIN)/contbed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	@touch $@

$(VENV)/.test: $(BIN)/contbed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test,forms,dev,docs,report,notebook]'
	@touch $@

# root on Debian or Ubuntu gets the system packages; anyone else is told, and the tests that need them are skipped by name
system:
	@if command -v dpkg >/dev/null && ! dpkg -s $(SYSTEM) >/dev/null 2>&1; then \
	  if [ "$$(id -u)" = 0 ]; then apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qqy install --no-install-recommends $(SYSTEM) >/dev/null; \
	  else echo "optional system packages are missing: sudo apt-get install $(SYSTEM)"; fi; fi

clean:
	rm -rf $(VENV) $(VENV_DOLFINX) $(VENV_FLOORS) $(VENV_DIST) docs/_build docs/generated dist build *.egg-info results
