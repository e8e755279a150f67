# `make demo` and `make test` need python3 (3.10 to 3.13, with venv) and make; everything else is installed into .venv.
PYTHON ?= python3
BIN := .venv/bin
# Set by the ROS 2 wheels of another virtual environment, this would keep those of .venv from finding their libraries.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE

.PHONY: help demo test test-fast guide lint bench fuzz campaign soak docs clean python environment

help:
	@echo "make demo    install into .venv, run the circle test over ROS 2 topics, close a gap, budget of a measured machine"
	@echo "make test    all tests of the code"
	@echo "make test-fast  without ROS and slow tests, below a minute"
	@echo "make guide   every command of README and guide as printed, and the notebooks"
	@echo "make lint    style, format, types, layers"
	@echo "make bench   speed, compared with a peer in the same run"
	@echo "make fuzz    fuzz every parser with damaged and hostile input (15 min)"
	@echo "make campaign  repeated identifications, hours; resumes after an abort"
	@echo "make soak    endurance and faults, two hours; resumes after an abort"
	@echo "make docs    the guide as pages, in site/"
	@echo "make clean   remove .venv and all generated files"

demo: EXTRAS = view
demo: environment
	@$(BIN)/flexros demo

test: EXTRAS = test
test: environment
	@$(BIN)/python -m pytest -n 3 --dist loadfile --max-worker-restart=0 -m "not guide" $(PYTEST_OPTIONS)

test-fast: EXTRAS = test
test-fast: environment
	@$(BIN)/python -m pytest -n 2 --dist loadfile -m "not ros and not slow and not guide" $(PYTEST_OPTIONS)

guide: EXTRAS = test
guide: environment
	@$(BIN)/python -m pytest -n 3 --max-worker-restart=0 -m guide $(PYTEST_OPTIONS) tests/contracts

lint: EXTRAS = dev test
lint: environment
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports --no-cache

bench: EXTRAS = test
bench: environment
	@mkdir -p docs/results && $(BIN)/flexros bench --out docs/results/benchmarks.md

fuzz: EXTRAS = test
fuzz: environment
	@$(BIN)/python -m tests.fuzz.campaign 15 docs/results

campaign: environment
	@$(BIN)/flexros campaign --out docs/results --work bags/campaign

soak: EXTRAS = test
soak: environment
	@$(BIN)/python -m tests.soak.endurance_page

docs: EXTRAS = docs
docs: environment
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

environment: python
	@$(PYTHON) environment.py $(EXTRAS)

python:
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null || { \
	found=$$(command -v "$(PYTHON)" >/dev/null && $(PYTHON) --version 2>&1 || echo missing); \
	echo "FlexROS needs Python 3.10 to 3.13, '$(PYTHON)' is $$found; give another one: make PYTHON=python3.12 ..." >&2; exit 2; }

clean:
	@rm -rf .venv build install log dist site flexros.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +
