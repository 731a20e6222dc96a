# make demo     fly the paper's mission with three ROS 2 nodes and write output/demo/report.html
# make test     lint, type-check and test
# make docs     write the tables of the README from the code
# make figures  fly the comparison again for docs/flight.md: table, pictures, docs/flight.gif
# All keep their environment in .venv; PYTHON chooses the interpreter (3.10 to 3.13).

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# An apt ROS 2 that is sourced in this shell must not mix with the wheels in .venv.
CLEAN := env -u PYTHONPATH -u LD_LIBRARY_PATH -u AMENT_PREFIX_PATH -u _ROS_WHEELS_BOOTSTRAP_COMPLETE
CHECKED := ROS_PYTHON_CHECK_FIELDS=1

.PHONY: demo test lint docs figures clean

demo: $(VENV)/demo
	@$(CLEAN) $(BIN)/uav_tracking fly --config paper --output output/demo

test: lint
	$(CLEAN) $(CHECKED) $(BIN)/python -m pytest -m "not nodes" -n 2
	$(CLEAN) $(CHECKED) $(BIN)/python -m pytest -m nodes

lint: $(VENV)/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(CLEAN) $(BIN)/mypy

clean:
	rm -rf $(VENV) build install log output *.egg-info

$(VENV)/bin/python:
	@echo "Setting up $(VENV), once: about two minutes."
	@$(PYTHON) -m venv $(VENV)

$(VENV)/demo: $(VENV)/bin/python setup.py
	@$(CLEAN) $(BIN)/python -m pip install --quiet --editable '.[ros,proof]'
	@touch $@

$(VENV)/test: $(VENV)/bin/python setup.py
	@$(CLEAN) $(BIN)/python -m pip install --quiet --editable '.[ros,proof,test]'
	@touch $@ $(VENV)/demo

docs: $(VENV)/test
	$(CLEAN) $(BIN)/python -m uav_tracking_mpc.nodes.reference_tables README.md

figures: $(VENV)/demo
	$(CLEAN) $(BIN)/uav_tracking compare --config small_uav --output output/compare --page docs/flight.md
	cp output/compare/*.png docs/flight/
	$(CLEAN) $(BIN)/uav_tracking simulate --config small_uav --scenario circling_target --animation --output output/flight
	cp output/flight/flight.gif docs/
