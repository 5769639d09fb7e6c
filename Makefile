# Everything a user needs. Each target installs what it needs first; a machine needs Python 3.11 to 3.13 with venv, and make.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
MODELS ?= models
HOST ?= 127.0.0.1
PORT ?= 8000
# Headless rendering for the tests' outside opinion (pyrender).
export PYOPENGL_PLATFORM := egl

.PHONY: help install install-service demo models test test-tools check serve frontier stability bench bench-render bench-service bench-soak \
	bench-automatic bench-rendering bench-judging bench-ceilings bench-free-codes bench-learning bench-parsimony bench-cutouts bench-refinement bench-several bench-samples bench-symmetry bench-fronts bench-training bench-waiting fuzz

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{ printf "  make %-16s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

TURNTABLE := service/page/turntable/model-viewer.min.js

install: $(VENV)/.installed $(TURNTABLE)  ## install everything into .venv

# torch first and pinned: on machines without a GPU its CPU build is a tenth of the size, where the index offers one.
$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet torch==2.13.0
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	touch $@

# What the service's page turns meshes with; without it the page works, and says so.
$(TURNTABLE): service/page/turntable/package-lock.json
	@service/page/turntable/install.sh $(PYTHON)

install-service: $(VENV)-service/.installed $(TURNTABLE)  ## install the service alone, without torch, into .venv-service

$(VENV)-service/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)-service
	$(VENV)-service/bin/python -m pip install --quiet --upgrade pip
	$(VENV)-service/bin/python -m pip install --quiet --editable .
	touch $@

demo: install  ## pictures of cars → training without labels → judge → ONNX → service → a GLB from a picture (out/demo)
	rm -rf out/demo
	$(BIN)/python scripts/demo.py --output out/demo

models: install  ## train, choose, judge and export all models that ship (models; some seven hours, goes on where it was)
	$(BIN)/python scripts/models.py

# Processes share the tests, each with one thread for torch: tensors are small, and two threads take longer than one.
test: install  ## install everything and run all tests
	@$(BIN)/python scripts/compile_kernels.py & $(MAKE) --no-print-directory test-tools && wait $$!
	OMP_NUM_THREADS=1 OMP_WAIT_POLICY=PASSIVE $(BIN)/python -m pytest --numprocesses auto --maxprocesses 4 --dist worksteal

test-tools: install install-service tests/validator/node_modules/.installed tests/service/page/node_modules/.installed
	@scripts/install_egl.sh $(BIN)/python
	@tests/service/page/install_browser.sh $(BIN)/python
	@tests/service/install_proxy.sh

# The Khronos validator of GLB files, and the checker of the page's accessibility, at the versions that are locked.
tests/%/node_modules/.installed: tests/%/package-lock.json
	@command -v npm >/dev/null || { echo "expected npm, found none; install node and npm (Debian: apt-get install npm)" >&2; exit 1; }
	npm ci --silent --no-audit --no-fund --prefix tests/$*
	touch $@

check: install  ## formatting, lint, types, the layering of the packages, and the Dockerfile
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/hadolint Dockerfile

serve: install-service  ## serve the bundles in MODELS (default: those that ship) on HOST:PORT
	$(VENV)-service/bin/python -m service --host $(HOST) --port $(PORT) --models $(MODELS)

$(VENV)/.bench: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	touch $@

bench-render: $(VENV)/.bench  ## the renderer beside DEODR and Mitsuba 3 (benchmarks/render.json and .png; about 40 minutes)
	$(BIN)/python -m benchmarks.render

bench-service: $(VENV)/.bench  ## the service beside its two ONNX graphs alone (benchmarks/service.json and .png; about 3 minutes)
	$(BIN)/python -m benchmarks.service --models $(MODELS)

bench-soak: $(VENV)/.bench  ## the service under load for long: 64 clients, twice its capacity, 100,000 requests (benchmarks/service_soak.json; about 20 minutes)
	$(BIN)/python -m benchmarks.service_soak --models $(MODELS)

fuzz: $(VENV)/.bench  ## 100,000 more executions of a coverage-guided fuzzer on pictures and bundles (docs/results/fuzz.json)
	$(BIN)/python -m benchmarks.fuzz

bench-ceilings: install  ## how far meshes of each kind can come at all (docs/results/ceilings.json; about 20 minutes)
	$(BIN)/python -m benchmarks.ceilings

bench-free-codes: install  ## what holds shapes back when neither poses nor the encoder do (docs/results/free-codes.json; about 10 minutes)
	$(BIN)/python -m benchmarks.free_codes

bench-learning: install  ## accuracy over training time, the paper's objective beside ours (docs/results/learning.json; about 20 minutes)
	$(BIN)/python -m benchmarks.learning

bench-parsimony: install  ## what bundles carry, and what float16 and int8 cost and save (docs/results/parsimony.json)
	$(BIN)/python -m benchmarks.parsimony

bench-refinement: install  ## what a longer look gains, for every model that ships (benchmarks/refinement.json; about 30 minutes)
	$(BIN)/python -m benchmarks.refinement

bench-several: install  ## what several pictures of an object tell beyond one, for every model that ships (docs/results/several.json; about 15 minutes)
	$(BIN)/python -m benchmarks.several $(if $(wildcard $(MESHES)),--real-meshes $(MESHES))

bench-cutouts: install  ## what it costs accuracy that an object had to be cut out, and that it is darker or brighter, for every model that ships (benchmarks/cutouts.json; about 15 minutes)
	$(BIN)/python -m benchmarks.cutouts

bench-symmetry: install  ## which turns the posteriors of poses do not tell apart, beside the objects' own symmetry (docs/results/symmetry.json; about 3 minutes)
	$(BIN)/python -m benchmarks.symmetry $(if $(wildcard $(MESHES)),--real-meshes $(MESHES))

bench-fronts: install  ## which objects stand back to front, by what makes shapes most alike, and whether they do (docs/results/fronts.json; about 8 minutes)
	$(BIN)/python -m benchmarks.fronts

bench-samples: install  ## whether samples look like what a model makes of pictures, from the prior and as they are served (docs/results/samples.json; about 3 minutes)
	$(BIN)/python -m benchmarks.samples

bench-automatic: install  ## which category `auto` names, asked about objects of each class (docs/results/auto.json; about 2 minutes)
	$(BIN)/python -m benchmarks.automatic

bench-rendering: install  ## training pictures rendered a second, each class (benchmarks/rendering.json; about 12 minutes)
	$(BIN)/python -m benchmarks.rendering

MESHES ?= ../shared/meshes
bench-judging: install  ## how long the judge takes for 100 of the mesh files in MESHES (benchmarks/judging.json; about 3 minutes)
	$(BIN)/python -m benchmarks.judging --meshes $(MESHES)

bench-training: $(VENV)/.bench  ## trainings by processes and threads, and where the time goes (benchmarks/training.json; about 15 minutes)
	$(BIN)/python -m benchmarks.training

bench-waiting: install  ## a training's step by itself and beside other work, by how long its threads wait awake (docs/results/waiting.json; about 15 minutes)
	$(BIN)/python -m benchmarks.waiting

BUDGET ?= full
frontier: install  ## accuracy against cost, charted (out/frontier; BUDGET=small takes minutes, full one to two hours of a core)
	$(BIN)/python -m trainer frontier --budget $(BUDGET)

stability: install  ## where models, trainings and the rasteriser break, and whether they warn (docs/stability.md; about an hour)
	$(BIN)/python -m trainer render --class car --seed 1 --instances 200 --output out/stability/calibration
	$(BIN)/python -m exporter --bundle models/car --images out/stability/calibration --precision int8 --output out/stability/car-int8
	$(BIN)/python -m trainer stability --budget full --page docs/stability.template.md \
		--bundle models/car models/chair models/sofa out/stability/car-int8
	cp out/stability/full/stability.json docs/results/
	cp out/stability/full/stability.md docs/
	cp out/stability/full/stability-*.png docs/images/

bench: bench-render bench-service bench-training  ## renderer, service and trainings; the others by name
