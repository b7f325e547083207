# make run   compare the two systems of the sample recordings
# make test  lint, types, import contract, all tests with coverage
# make bench benchmarks against other tools, written to docs/benchmarks.md
#            (make bench BENCH=--quick: a minute, nothing written)

PYTHON ?= python3
BIN := .venv/bin
LIBRARY := $(BIN)/.installed
DEVELOP := $(BIN)/.installed-dev
TOOLS := .venv-bench/tools/.installed
MOTMETRICS := .venv-bench/motmetrics/.installed

.PHONY: run test bench lint clean

run: $(LIBRARY)
	$(BIN)/nvcore compare sample_data/session.toml

test: $(DEVELOP) lint
	$(BIN)/coverage erase
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -q --cov --cov-report= --cov-fail-under=0 tests/test_kernels.py tests/test_link_kernel.py
	$(BIN)/python -m pytest -q --cov --cov-append

lint: $(DEVELOP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(LIBRARY) $(TOOLS) $(MOTMETRICS)
	$(BIN)/python -m bench.run $(BENCH)

# The virtual environment is made and filled once, and again only when a pinned version changes.
$(LIBRARY): requirements.txt pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps -e .
	touch $@

$(DEVELOP): $(LIBRARY) requirements-dev.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements-dev.txt
	touch $@

# The other tools live in environments of their own; motmetrics needs numpy 1, which not every
# Python has: its row of the table then says so.
$(TOOLS): bench/requirements-bench.txt
	$(PYTHON) -m venv .venv-bench/tools
	.venv-bench/tools/bin/python -m pip install --quiet --disable-pip-version-check -r $<
	touch $@

$(MOTMETRICS): bench/requirements-motmetrics.txt
	$(PYTHON) -m venv .venv-bench/motmetrics
	.venv-bench/motmetrics/bin/python -m pip install --quiet --disable-pip-version-check -r $< && touch $@ || true

clean:
	rm -rf .venv .venv-bench* .coverage .pytest_cache .mypy_cache .ruff_cache build *.egg-info
