# make demo               the whole tracker on a simulated camera, three processes, no ROS needed
# make demo DEVICE=/dev/video0   the same on a real camera, until Ctrl-C
#      CAMERA_INFO=file.yaml   its calibration
# make doctor             what is wrong with this machine, and what to do about it
# make test               all tests
#      PYTEST='-k segmenter'   a part of them
# make soak               the tracker for half an hour in place of a minute, its memory watched;
#                         then the camera driver's tests with as much streaming in place of 20 s
#      SOAK_SECONDS=3600   another time
#      PYTEST='-k grows'   the tracker alone
# make bench              beside other people's methods, 20 minutes, out/benchmarks
#      BENCH='speed --quick'   a part (accuracy, speed, real, detection, search, motion, tracking,
#                              capture, latency, world), less of it
#      BLOB_TRACKER_DATA=folder   where the real pixels are
# make study              the thesis' tables and figures done again, out/studies/report.html
#      STUDY='table_3_3 beyond --quick'   a part of them, less of it
# make reference          config/tracker.yaml, README's tables and config/security/policy.xml, from
#                         the nodes' declarations
# PYTHON=python3.12       another interpreter, 3.10 to 3.13, after `make clean`

SHELL := /bin/bash
.SHELLFLAGS := -e -o pipefail -c
.DEFAULT_GOAL := help
PYTHON ?= python3
DEVICE ?=
CAMERA_INFO ?=
OUT ?= out
STUDY ?= all
SOAK_SECONDS ?= 1800

BIN := .venv/bin
SOURCES := $(shell find blob_tracker config examples launch resource -type f -not -name '*.pyc') \
	package.xml setup.py setup.cfg
ENVIRONMENT := source install/setup.bash && export PATH="$(CURDIR)/$(BIN):$$PATH" \
	FASTRTPS_DEFAULT_PROFILES_FILE="$(CURDIR)/config/fastdds.xml"

.PHONY: help demo doctor test soak bench study reference clean
help:
	@grep '^# ' Makefile | cut -c3-

demo: install/.built
	@$(ENVIRONMENT) && python -m blob_tracker demo --out $(OUT) \
	  $(if $(DEVICE),--device $(DEVICE)) $(if $(CAMERA_INFO),--camera-info $(CAMERA_INFO))

doctor: install/.built
	@$(ENVIRONMENT) && python -m blob_tracker doctor

test: install/.built .venv/.test
	@# pytest alone, not python -m: what colcon installed is tested, not what lies here. One
	@# process runs what starts nodes, the other the virtual machine and what only computes.
	@$(ENVIRONMENT) && pytest -n 2 $(PYTEST)

soak: export SOAK_SECONDS := $(SOAK_SECONDS)
soak: install/.built .venv/.test
	@$(ENVIRONMENT) && pytest -s test/nodes/test_soak.py test/vm/test_controls.py $(PYTEST)

bench: .venv/.bench  # reads the package from the source tree: it needs neither ROS nor a build
	@OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks --out $(OUT)/benchmarks $(BENCH)

study: .venv/.run  # as bench does
	@PYTHONPATH=. $(BIN)/python -m blob_tracker study --out $(OUT)/studies $(STUDY)

reference: .venv/.run  # as bench does
	@PYTHONPATH=. $(BIN)/python tools/reference.py

.venv/.run: requirements.txt
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(0 if (3, 10) <= v <= (3, 13) else \
	  "Python %d.%d cannot run the ROS wheels; set PYTHON to one of 3.10 to 3.13" % v)'
	@test -x $(BIN)/pip || $(PYTHON) -m venv .venv || { rm -rf .venv; \
	  echo 'Python has no venv module here: sudo apt install python3-venv' >&2; exit 1; }
	$(BIN)/pip install --quiet --disable-pip-version-check -r requirements.txt
	@touch $@

.venv/.test: requirements/test.txt requirements/opencv5.txt .venv/.run
	$(BIN)/pip install --quiet --disable-pip-version-check -r requirements/test.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --upgrade \
	  --target .venv/opencv5 -r requirements/opencv5.txt
	@touch $@

.venv/.bench: requirements/benchmarks.txt .venv/.run
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps -r $<
	@touch $@

install/.built: .venv/.run $(SOURCES)
	$(BIN)/colcon list --paths . | grep -q '(ros.ament_python)' || { \
	  echo 'package.xml is not valid: colcon does not see an ament_python package' >&2; exit 1; }
	@rm -rf build install  # colcon leaves behind what a source tree no longer has
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/colcon build --paths . \
	  --event-handlers console_direct-
	@# The kernels are compiled now, into the installed package, not when a node first starts.
	@$(ENVIRONMENT) && cd .venv && \
	  python -c 'from blob_tracker.pipeline import compile_ahead; compile_ahead()'
	@touch $@

clean:
	rm -rf .venv build install log .cache $(OUT)
