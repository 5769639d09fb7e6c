# Everything a user needs. Each target installs what it needs first; a machine needs Python 3.11 to 3.13 with venv, and make.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
MODELS ?= out/demo/models
HOST ?= 127.0.0.1
PORT ?= 8000
# Headless rendering for the tests' outside opinion (pyrender).
export PYOPENGL_PLATFORM := egl

.PHONY: help install install-service demo test check serve bench-render

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{ printf "  make %-16s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

install: $(VENV)/.installed  ## install everything into .venv

# torch first and pinned: on machines without a GPU its CPU build is a tenth of the size, where the index offers one.
$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet torch==2.13.0
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	touch $@

install-service: $(VENV)-service/.installed  ## install the service alone, without torch, into .venv-service

$(VENV)-service/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)-service
	$(VENV)-service/bin/python -m pip install --quiet --upgrade pip
	$(VENV)-service/bin/python -m pip install --quiet --editable .
	touch $@

demo: install  ## pictures of cars → training without labels → judge → ONNX → service → a GLB from a picture (out/demo)
	rm -rf out/demo
	$(BIN)/python scripts/demo.py --output out/demo

test: install install-service tests/validator/node_modules/.installed  ## install everything and run all tests
	@scripts/install_egl.sh $(BIN)/python
	$(BIN)/python -m pytest

# The Khronos validator of GLB files, at the version that package-lock.json names.
tests/validator/node_modules/.installed: tests/validator/package-lock.json
	@command -v npm >/dev/null || { echo "expected npm, found none; install node and npm (Debian: apt-get install npm)" >&2; exit 1; }
	npm ci --silent --no-audit --no-fund --prefix tests/validator
	touch $@

check: install  ## formatting, lint, types and the layering of the packages
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

serve: install-service  ## serve the bundles in MODELS (default: the demo's) on HOST:PORT
	$(VENV)-service/bin/python -m service --host $(HOST) --port $(PORT) --models $(MODELS)

$(VENV)/.bench: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	touch $@

bench-render: $(VENV)/.bench  ## the renderer beside DEODR and Mitsuba 3 (benchmarks/render.json and .png; about 40 minutes)
	@ldconfig -p | grep -q libLLVM || echo "expected LLVM's library for Mitsuba 3, found none; measuring without it (Debian: apt-get install libllvm19)" >&2
	$(BIN)/python -m benchmarks.render
