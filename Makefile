# make run   the dashboard, on the sample recordings
#            (make run LOCAL_ROOT=DIR: it may also open what lies below that folder)
# make check lint, types, import contracts, the tests of the library: for every day
# make test  the same with the tests of the pages, and of the app in a browser
# make coverage  which lines of the library its tests run: at least 95 %, kernels as plain Python
# make lint  lint, types and import contracts alone
# make docs  the help texts and tables of docs/ that the code says, written anew
# make bench benchmarks against other tools, written to docs/benchmarks.md
#            (make bench BENCH=--quick: a minute, nothing written)
# make mutants  small mistakes put into the library: which do the tests not notice?
#            (half an hour; the table goes to docs/quality.md by hand)

PYTHON ?= python3
BIN := .venv/bin
LIBRARY := $(BIN)/.installed
DEVELOP := $(BIN)/.installed-dev
TOOLS := .venv-bench/tools/.installed
MOTMETRICS := .venv-bench/motmetrics/.installed

# Compiled modules are kept, also where the environment asks for none: else every process that a
# test starts compiles them anew, and each of pytest's workers rewrites all assertions.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run check test coverage bench mutants lint docs chromium clean

run: $(LIBRARY)
	$(BIN)/streamlit run app.py $(if $(LOCAL_ROOT),-- --local-root "$(LOCAL_ROOT)")

check: $(DEVELOP) lint
	$(BIN)/python -m pytest -q -n auto --dist loadfile --ignore=tests/ui --ignore=tests/e2e

# The browser tests run by themselves: they look at what is painted in time. In the order of their
# names: the app's few long files first, else one of them is left alone at the end.
test: $(DEVELOP) chromium lint
	$(BIN)/python -m pytest -q -n auto --dist loadfile --ignore=tests/e2e
	$(BIN)/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder tests/e2e

coverage: $(DEVELOP)
	$(BIN)/coverage erase
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -q --cov --cov-report= --cov-fail-under=0 tests/metrics/test_kernels.py tests/metrics/test_link_kernel.py
	$(BIN)/python -m pytest -q -n auto --dist loadfile --cov --cov-append --ignore=tests/e2e

lint: $(DEVELOP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(DEVELOP)
	PYTHONPATH=tests/helpers $(BIN)/python tests/cli/test_docs_cli.py
	PYTHONPATH=tests/helpers $(BIN)/python tests/tables/test_docs_report.py

# The browser tests drive Debian's Chromium without windows; where it is missing and may be installed, it is.
chromium:
	@command -v chromium-headless-shell > /dev/null || test -n "$$NVCORE_CHROMIUM" || \
	if [ "$$(id -u)" = 0 ] && command -v apt-get > /dev/null; then \
	    apt-get update -qq && apt-get install -qq -y --no-install-recommends chromium-headless-shell > /dev/null; \
	else \
	    echo "The browser tests need Chromium: install the package chromium-headless-shell, or set NVCORE_CHROMIUM to the program."; \
	fi

bench: $(DEVELOP) chromium $(TOOLS) $(MOTMETRICS)
	$(BIN)/python -m bench.run $(BENCH)

mutants: $(DEVELOP)
	$(BIN)/python -m scripts.mutants map
	$(BIN)/python -m scripts.mutants run --fresh

# The virtual environment is made and filled once, and again only when a pinned version changes.
$(LIBRARY): requirements.txt pyproject.toml
	@echo "Installing into .venv: about a minute, once."
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --config-settings editable_mode=compat -e .
	touch $@

$(DEVELOP): $(LIBRARY) requirements-dev.txt
	@echo "Installing what the tests need: about a minute, once."
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
	rm -rf .venv .venv-bench* .mutants .coverage .pytest_cache .mypy_cache .ruff_cache build *.egg-info
