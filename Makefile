# make demo               the whole tracker on a simulated camera, three processes, no ROS needed
# make demo DEVICE=/dev/video0   the same on a real camera, until Ctrl-C
#      CAMERA_INFO=file.yaml   its calibration
#      LIGHT=free   a light on its own clock, in place of one wired to the camera
# make demo LIGHT=free    simulated: a light that runs free at 13.7 Hz; LIGHT=coded: three with codes;
#                         LIGHT=constellation: a drone with five, and its pose
# make doctor             what is wrong with this machine, and what to do about it
# make check              from the source tree, nothing is built: all tests that start no node and
#                         no virtual machine, the linters and mypy beside them; five minutes
#      TESTS=test/segmentation/test_box.py   these tests alone, of whatever kind; a second
# make lint               the ROS linters and mypy
# make test               all tests of the installed package, the linters and mypy beside them
#      PYTEST='-k segmenter'   a part of them
# make soak               the tracker for half an hour in place of a minute, its memory watched;
#                         then the camera driver's tests with as much streaming in place of 20 s
#      SOAK_SECONDS=3600   another time
#      PYTEST='-k grows'   the tracker alone
# make bench              beside other people's methods, 20 minutes, out/benchmarks
#      BENCH='speed --quick'   a part (accuracy, speed, real, detection, search, motion, tracking,
#                              capture, latency, world, blink, files, pose, triangulation), less
#      BENCH='latency --beside folder'   the nodes beside those of another source tree (a git
#                              worktree of another commit), in turns: ratios; ten minutes;
#                              with --load beside a process that keeps a core busy
#      BLOB_TRACKER_DATA=folder   where the real pixels are
# make study              the thesis' tables and figures done again, out/studies/report.html
#      STUDY='table_3_3 beyond --quick'   a part of them, less of it
# make reference          config/tracker.yaml, config/security/policy.xml, docs/nodes.md and docs/nodes/,
#                         from the nodes' declarations
# make docs               the documents and the Python interface as a site, out/docs; offline too, once
#                         its tools are installed
# PYTHON=python3.12       another interpreter, 3.10 to 3.13, after `make clean`

SHELL := /bin/bash
.SHELLFLAGS := -e -o pipefail -c
.DEFAULT_GOAL := help
PYTHON ?= python3
DEVICE ?=
LIGHT ?=
CAMERA_INFO ?=
OUT ?= out
STUDY ?= all
TESTS ?=
SOAK_SECONDS ?= 1800

BIN := .venv/bin
SOURCES := $(shell find blob_tracker config examples launch resource -type f -not -name '*.pyc' -not -name '*.so' \
	  -not -name '*.nb[cim]') \
	package.xml setup.py setup.cfg
ENVIRONMENT := source install/setup.bash && export PATH="$(CURDIR)/$(BIN):$$PATH" \
	FASTRTPS_DEFAULT_PROFILES_FILE="$(CURDIR)/config/fastdds.xml"

# The source tree in the place of the installed package.
IN_PLACE := export PATH="$(CURDIR)/$(BIN):$$PATH" PYTHONPATH="$(CURDIR)" \
	AMENT_PREFIX_PATH="$(CURDIR)/.cache/overlay" \
	FASTRTPS_DEFAULT_PROFILES_FILE="$(CURDIR)/config/fastdds.xml"
LINTED := blob_tracker test launch benchmarks examples tools doc setup.py
# Runs the linters while a command runs, in the time that it leaves; what they say comes after it.
LINT_BESIDE = mkdir -p .cache && { nice $(MAKE) --no-print-directory lint >.cache/lint.log 2>&1 & \
	  lint=$$!; ended=0; $(1) || ended=$$?; \
	  wait $$lint && tail -n 1 .cache/lint.log || { cat .cache/lint.log; ended=1; }; exit $$ended; }

.PHONY: help demo doctor check lint test soak bench study reference docs clean
help:
	@grep '^# ' Makefile | cut -c3-

demo: install/.built
	@$(ENVIRONMENT) && python -m blob_tracker demo --out $(OUT) \
	  $(if $(LIGHT),--light $(LIGHT)) $(if $(DEVICE),--device $(DEVICE)) $(if $(CAMERA_INFO),--camera-info $(CAMERA_INFO))

doctor: install/.built
	@$(ENVIRONMENT) && python -m blob_tracker doctor

check: .venv/.test .cache/overlay .cache/direct
ifeq ($(TESTS),)
	@$(IN_PLACE) && $(call LINT_BESIDE,pytest -n 2 --core $(PYTEST))
else
	@# Hypothesis' plugin takes a second to load, and reports no more than the tests do.
	@$(IN_PLACE) && pytest -p no:hypothesispytest $(TESTS) $(PYTEST)
endif

lint: .venv/.test
	@# Told what failed, but only after all three have looked.
	@failed=0; PATH="$(CURDIR)/$(BIN):$$PATH"; \
	  python -m ament_flake8.main $(LINTED) | grep -Ev '^(checking|\*) ' || failed=1; \
	  python -m ament_pep257.main $(LINTED) | grep -Ev '^(checking|\*) ' || failed=1; \
	  python -m mypy || failed=1; exit $$failed

test: install/.built .venv/.test
	@# pytest alone, not python -m: what colcon installed is tested, not what lies here.
	@$(ENVIRONMENT) && $(call LINT_BESIDE,pytest -n 2 $(PYTEST))

soak: export SOAK_SECONDS := $(SOAK_SECONDS)
soak: install/.built .venv/.test
	@$(ENVIRONMENT) && pytest -s test/nodes/test_soak.py test/vm/test_controls.py $(PYTEST)

bench: .venv/.bench  # reads the package from the source tree: it needs neither ROS nor a build
	@OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks --out $(OUT)/benchmarks $(BENCH)

study: .venv/.run  # as bench does
	@PYTHONPATH=. $(BIN)/python -m blob_tracker study --out $(OUT)/studies $(STUDY)

reference: .venv/.run  # as bench does
	@PYTHONPATH=. $(BIN)/python tools/reference.py

docs: .venv/.docs  # as bench does; the links in doc/ are followed, as rosdoc2 does
	@rm -rf .cache/docs && mkdir -p .cache && cp -rL doc .cache/docs
	@PYTHONPATH=. $(BIN)/python -m sphinx -W --keep-going -q -d .cache/doctrees .cache/docs $(OUT)/docs
	@echo '$(OUT)/docs/index.html'

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

.venv/.docs: requirements/docs.txt .venv/.run
	$(BIN)/pip install --quiet --disable-pip-version-check -r $<
	@touch $@

install/.built: .venv/.run $(SOURCES)
	$(BIN)/colcon list --paths . | grep -q '(ros.ament_python)' || { \
	  echo 'package.xml is not valid: colcon does not see an ament_python package' >&2; exit 1; }
	@# Machine code outlives the package that it was compiled for; the first one takes that of
	@# `make check`. A kernel is compiled anew only where what is compiled into it has changed.
	@rm -rf .cache/kernels && mkdir -p .cache/kernels && \
	  { cd install/blob_tracker/lib/python*/site-packages 2>/dev/null || true; } && \
	  find blob_tracker -name '*.nb[cim]' -exec cp --parents -t "$(CURDIR)/.cache/kernels" {} +
	@rm -rf build install  # colcon leaves behind what a source tree no longer has
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/colcon build --paths . \
	  --event-handlers console_direct-
	@cp -r .cache/kernels/. install/blob_tracker/lib/python*/site-packages/
	@# Where PYTHONDONTWRITEBYTECODE is set, each process would compile the package's sources.
	$(BIN)/python -m compileall -q install/blob_tracker/lib
	@# The kernels are compiled now, into the installed package, not when a node first starts: those
	@# of the segmentation beside the others, which take as long.
	@$(ENVIRONMENT) && cd .venv && { \
	  python -c 'from blob_tracker import segmentation; segmentation.compile_ahead()' & \
	  python -c 'from blob_tracker import constellation, location, tracking; \
	    location.compile_ahead(); location.pulse_learner.compile_ahead(); tracking.compile_ahead(); \
	    constellation.compile_ahead()' && \
	  wait $$! && python -c 'from blob_tracker.pipeline import compile_ahead; compile_ahead()'; }
	@# `python -m blob_tracker` that is typed here takes the package of this folder: it need not
	@# compile what has just been compiled.
	@cd install/blob_tracker/lib/python*/site-packages && \
	  find blob_tracker -name '*.nb[cim]' -exec cp --parents -t "$(CURDIR)" {} +
	@touch $@

.cache/overlay: tools/overlay.py blob_tracker/nodes/__init__.py .venv/.run
	@$(BIN)/python tools/overlay.py $@

# Calls kernels without the compiler, see DEVELOPING.md; where there is no C compiler, Numba does.
.cache/direct: blob_tracker/kernel/direct.c setup.py .venv/.run
	@mkdir -p .cache
	@$(BIN)/python setup.py -q build_ext --inplace --build-temp .cache/build
	@touch $@

clean:
	rm -f blob_tracker/kernel/*.so
	rm -rf .venv build install log .cache $(OUT)
