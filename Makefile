PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test test-long fuzz lint install bench clean

demo: .venv/installed
	$(BIN)/posreal design vertical-comfort

test: .venv/installed-dev lint
	$(BIN)/python -m pytest -n auto -m "not long and not fuzz"

test-long: .venv/installed-dev
	$(BIN)/python -m pytest -n auto -m "not fuzz"

fuzz: .venv/installed-dev
	$(BIN)/python -m pytest -n auto -m fuzz tests/fuzz

lint: .venv/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

install: .venv/installed

bench: .venv/installed-dev
	$(BIN)/python -m benchmarks

.venv/bin/python:
	$(PYTHON) -c 'import sys; sys.exit("posreal needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Try: make PYTHON=python3.12 ...") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv .venv

.venv/installed: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	touch $@

.venv/installed-dev: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[dev]"
	touch .venv/installed $@

clean:
	rm -rf .venv dist build .pytest_cache .mypy_cache .ruff_cache
