# make demo       fly the paper's mission with three ROS 2 nodes and write output/demo/report.html
# make view       fly small_uav in wind on a page in the browser: watch and steer it, until Ctrl-C
# make test       lint, type-check and test
# make test-long  every example and every long form, and the tests with the kernels of other processors
# make size       files, statements, tokens and lines of code, by room
# make golden     fly the records of test/golden again and say what differs; RECORD=1 writes them
# make mutants    let the tests find 50 mutants of the package, as many as those of AGAINST=REV find;
#                 it takes hours
# make docs       build the documentation site in docs/_build, with the tables of its reference;
#                 a warning, or a word that neither English nor the glossary knows, ends it
# make figures    fly again for docs/flight.md, margins.md, identification.md: tables and pictures
# make gallery    take the pictures of docs/gallery.md again, with chromium: half an hour at most
# make campaign   fly the 2000 flights of docs/campaign.md again: tables and picture; about an hour
# make lint       style and types alone
# make clean      remove .venv and all that was built
# All keep their environment in .venv; PYTHON chooses the interpreter (3.10 to 3.13).

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# An apt ROS 2 that is sourced in this shell must not mix with the wheels in .venv. And where nothing
# keeps what Python has compiled, as in many containers, each process of a test compiles it again.
CLEAN := env -u PYTHONPATH -u LD_LIBRARY_PATH -u AMENT_PREFIX_PATH \
	-u _ROS_WHEELS_BOOTSTRAP_COMPLETE -u PYTHONDONTWRITEBYTECODE
PYTEST := $(CLEAN) ROS_PYTHON_CHECK_FIELDS=1 $(BIN)/python -m pytest
# More than there are cores: tests of nodes and pages mostly wait.
WORKERS ?= 4
# A test that hangs, in a library's code too, prints every stack and ends its worker, which counts as
# a failure. How long a test takes says nothing about the product.
HUNG = -o faulthandler_timeout=$(LONGEST) -o faulthandler_exit_on_timeout=true
LONGEST := 1000
test-long: LONGEST := 10000
# Noise of attitude [rad], airspeed and velocity [m/s] of the flight in docs/identification.md.
NOISY := --set uav_simulator.attitude_noise=0.0087 --set uav_simulator.airspeed_noise=0.3 \
	--set uav_simulator.velocity_noise=0.3
REFERENCE := docs/reference/topics_and_parameters.md

.PHONY: demo view test together test-long golden mutants size lint docs figures gallery campaign clean

demo: $(VENV)/demo
	@$(CLEAN) $(BIN)/uav_tracking fly --config paper --output output/demo

view: $(VENV)/view
	@$(CLEAN) $(BIN)/uav_tracking simulate --view --config small_uav --scenario wind --output output/view

test: $(VENV)/test
	@$(MAKE) --no-print-directory -j 2 lint together
	$(PYTEST) $(HUNG) -m "alone and not long" $$(grep -lr --include='test_*.py' mark.alone test)

# Threads of linear algebra, of which each worker has one a core, wait for one another by counting.
together: $(VENV)/compiled
	OPENBLAS_NUM_THREADS=1 $(PYTEST) $(HUNG) -m "not alone and not long" -n $(WORKERS) --dist loadfile

test-long: $(VENV)/test
	$(PYTEST) $(HUNG) --hypothesis-profile=full -m "not nodes and not browser" -n 2 --dist loadfile
	$(PYTEST) $(HUNG) --hypothesis-profile=full -m "nodes and long" --durations=0 --durations-min=60
	$(CLEAN) ROS_PYTHON_CHECK_FIELDS=1 $(BIN)/python test/on_every_processor.py -m "not nodes and not browser and not long" -n 2

size:
	@$(PYTHON) test/size.py

golden: $(VENV)/test
	$(CLEAN) OPENBLAS_CORETYPE=Haswell $(BIN)/python test/golden/golden.py $(if $(RECORD),--record)

mutants: $(VENV)/mutants
	$(CLEAN) $(BIN)/python test/mutant_trial.py $(if $(AGAINST),--against $(AGAINST))

lint: $(VENV)/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(CLEAN) $(BIN)/mypy

docs: $(VENV)/docs
	$(CLEAN) $(BIN)/python -m uav_tracking_mpc.nodes.ros.node_reference $(REFERENCE)
	$(CLEAN) $(BIN)/python test/constants.py
	$(CLEAN) $(BIN)/python -m sphinx -b html -q -W --keep-going -n -j auto docs docs/_build
	@echo "Read docs/_build/index.html."

figures: $(VENV)/demo
	$(CLEAN) $(BIN)/uav_tracking compare --config small_uav --output output/compare --page docs/flight.md
	$(CLEAN) $(BIN)/uav_tracking compare --config small_uav --mismatch --output output/compare --page docs/flight.md
	cp output/compare/*.png docs/flight/
	$(CLEAN) $(BIN)/uav_tracking margins --config small_uav --output output/margins --page docs/margins.md
	cp output/margins/margins.png docs/
	$(CLEAN) $(BIN)/uav_tracking simulate --config small_uav --scenario circling_target --animation --output output/flight
	cp output/flight/flight.gif docs/
	$(CLEAN) $(BIN)/uav_tracking simulate --config small_uav --scenario crosswind --excite $(NOISY) --output output/excited
	$(CLEAN) $(BIN)/uav_tracking identify output/excited/record.csv --output output/identified
	cp output/identified/response.png docs/identification.png

gallery: $(VENV)/test
	$(CLEAN) $(BIN)/python docs/make_gallery.py

campaign: $(VENV)/demo
	$(CLEAN) $(BIN)/uav_tracking campaign robustness --output output/campaigns/robustness --page docs/campaign.md
	cp output/campaigns/robustness/campaign.png docs/

clean:
	rm -rf $(VENV) build install log output docs/_build *.egg-info

$(VENV)/bin/python:
	@echo "Setting up $(VENV), once: about two minutes."
	@$(PYTHON) -m venv $(VENV)

$(VENV)/demo: $(VENV)/bin/python setup.py
	@$(CLEAN) $(BIN)/python -m pip install --quiet --editable '.[ros,campaign,mavlink,view]'
	@touch $@

$(VENV)/view: $(VENV)/bin/python setup.py
	@$(CLEAN) $(BIN)/python -m pip install --quiet --editable '.[view]'
	@touch $@

# Not compiled: of what is installed, tests import a tenth.
$(VENV)/test: $(VENV)/bin/python setup.py
	@$(CLEAN) $(BIN)/python -m pip install --quiet --no-compile --editable '.[ros,campaign,test]'
	@touch $@ $(VENV)/demo

# Workers that start together would each compile all that they import, tests too, which takes half a
# minute: one process compiles it before. What fails there fails again in the tests, in words.
$(VENV)/compiled: $(VENV)/test
	@$(PYTEST) --collect-only -qq >/dev/null || true
	@touch $@

$(VENV)/mutants: $(VENV)/test setup.py
	@$(CLEAN) $(BIN)/python -m pip install --quiet --editable '.[mutants]'
	@touch $@

$(VENV)/docs: $(VENV)/bin/python setup.py
	@$(CLEAN) $(BIN)/python -m pip install --quiet --editable '.[ros,campaign,mavlink,view,docs]'
	@touch $@ $(VENV)/demo
