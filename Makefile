# Two commands do all set-up on a fresh Debian machine with Python 3.11 or newer: make demo, make test.
PYTHON ?= python3
BIN := .venv/bin
PROJECT := pyproject.toml constraints.txt

# Without files of bytecode, each process of the tests compiles all sources anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test pytest check kernels packages bench fuzz mutants proofs boards docs docs-pdf docs-versions docs-transcripts docs-figures clean

demo: .venv/ready
	$(BIN)/irtiming demo

test:
	$(MAKE) --jobs --output-sync packages kernels .venv/ready-for-tests
	$(MAKE) --jobs pytest check

pytest: .venv/ready-for-tests
	OMP_NUM_THREADS=1 $(BIN)/pytest -n 3 --dist worksteal  # three on two cores: some wait for a rig

# Beside the tests, of which some measure time: nice.
check: .venv/ready-for-tests
	nice $(BIN)/ruff check
	nice $(BIN)/ruff format --check
	nice $(BIN)/mypy
	nice $(BIN)/lint-imports

# Once for all processes of the tests: each that finds them uncompiled compiles them anew.
kernels: .venv/ready
	scripts/compile-kernels $(BIN)/python

packages: .venv/ready  # which may ask for a package, too: one at a time
	scripts/system-packages gp:pari-gp gnuplot:gnuplot-nox arv-fake-gv-camera-0.8:aravis-tools arv-tool-0.8:aravis-tools-cli \
		pango-view:pango1.0-tools chromium:chromium

# Hostile inputs for an hour. scripts/fuzz --help tells how to ask for less, or for one input.
fuzz: .venv/ready-for-tests
	$(BIN)/python scripts/fuzz --minutes 60

# What the tests let through: hours. scripts/mutants --help tells how to ask for a part of it.
mutants: .venv/ready-for-tests
	$(BIN)/python scripts/mutants --random 200

# Speed and accuracy against named alternatives, some minutes; scripts/bench --long takes hours. Figures: docs/reference/benchmarks.md.
bench: .venv/ready-for-tests
	$(BIN)/python scripts/bench

proofs: .venv/ready-for-gateware
	$(BIN)/python scripts/prove

boards: .venv/ready-for-gateware
	$(BIN)/python scripts/board-reference docs/reference/trigger-generator-boards.md

# Python compiles a module when it is first imported; most of what is installed never is.
PIP = $(BIN)/pip install --quiet --no-compile --constraint constraints.txt

.venv/ready: $(PROJECT)
	scripts/make-venv $(PYTHON)
	$(PIP) --editable '.[rig]'
	touch $@

.venv/ready-for-tests: .venv/ready
	$(BIN)/python scripts/extra-requirements test >.venv/requirements-for-tests
	$(PIP) --requirement .venv/requirements-for-tests
	touch $@

.venv/ready-for-gateware: .venv/ready
	$(PIP) --editable '.[gateware]'
	touch $@

.venv/ready-for-docs: .venv/ready
	$(PIP) --editable '.[docs]'
	touch $@

# The site, in build/docs/index.html: a link that leads nowhere is an error. Nothing is fetched from other hosts.
docs: .venv/ready-for-docs
	$(BIN)/sphinx-build -E -W --keep-going -q -b html docs build/docs

# The same on paper: build/irtiming.pdf.
docs-pdf: .venv/ready-for-docs
	$(BIN)/sphinx-build -E -W --keep-going -q -t print -b singlehtml docs build/docs-print
	$(BIN)/python scripts/docs-pdf build/docs-print/index.html build/irtiming.pdf

# The sites of all releases and of the checkout: build/site/index.html.
docs-versions: .venv/ready-for-docs
	$(BIN)/python scripts/docs-versions build/site

# Every command of README.md and the tutorials is run, and what it prints compared with the page: some minutes.
docs-transcripts: .venv/ready
	$(BIN)/python scripts/tutorial-transcripts

docs-figures: .venv/ready
	$(BIN)/python scripts/wiring-drawing docs/explanation/trigger-generator-wiring.svg
	$(BIN)/python benchmarks/falling_rising_split.py --figure docs/explanation/falling-rising-split.svg
	$(BIN)/python benchmarks/radiance_and_lag.py --figure docs/explanation/radiance-straight-line.svg
	$(BIN)/python benchmarks/accuracy/light_of_a_pixel.py --figure docs/explanation/light-of-a-pixel.svg
	$(BIN)/python benchmarks/accuracy/biases.py --figure docs/explanation/biases.svg
	$(BIN)/python benchmarks/accuracy/scene_at_one_instant.py --figure docs/explanation/the-scene-at-one-instant.svg
	$(BIN)/python benchmarks/slot_table.py --rigs 0 --figure docs/explanation/slot-table.svg

clean:
	rm -rf .venv build demo
