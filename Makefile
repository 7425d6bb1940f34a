# `make demo` shows what wheelhop does, `make test` checks that it does it; `make check` asks only what
# is quick, `make test-all` also what takes minutes. All set up .venv the first time. `make wheels` tries
# wheel and sdist in clean environments, on every Python from 3.11 to 3.14 that is there or Debian has.

bin := .venv/bin

# Tests start hundreds of Pythons. Where these may not keep what they compile, each takes 3 s more.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: demo check test test-waiting test-computing test-beside-work test-all docs lint wheels oldest release \
	firmware firmware-budget clean

demo: .venv/installed
	$(bin)/wheelhop demo

slower := diagnose firmware chain workbench logger calibration api files component law identify \
	test_truth.py test_blind.py

check: lint
	$(bin)/pytest -n auto --dist worksteal $(addprefix --ignore=tests/,$(slower))

# Some tests wait for a browser or a board: they run beside those that compute.
waiting := tests/workbench tests/firmware tests/chain
slowest := --durations=15 --durations-min=3

test: .venv/installed-test
	$(MAKE) --no-print-directory --jobs=3 lint test-waiting test-computing

test-waiting: .venv/installed-test
	$(bin)/pytest $(slowest) $(waiting)

test-computing: .venv/installed-test
	$(bin)/pytest $(slowest) -n auto --dist worksteal $(addprefix --ignore=,$(waiting))

# Three times beside four busy loops: no test may hang on how fast a machine is.
test-beside-work: .venv/installed-test
	tools/beside_work.sh

test-all: lint
	$(bin)/pytest -n auto --dist worksteal -m "slow or not slow"

docs: .venv/installed-test
	NO_MKDOCS_2_WARNING=1 $(bin)/mkdocs build --strict --quiet

lint: .venv/installed-test
	$(bin)/ruff check
	$(bin)/ruff format --check
	$(bin)/mypy

wheels: .venv/installed-test
	tools/test_wheels.sh

# The lower bounds of pyproject.toml, to the letter, on Python 3.11.
oldest: .venv/installed-test
	tools/test_oldest.sh

# Everything of a release into dist/; without a tag it is a rehearsal. Nothing is uploaded.
release: .venv/installed-test
	tools/release.sh

firmware:
	tools/build_firmware.sh nano mega

firmware-budget: .venv/installed-test
	$(bin)/python tools/firmware_budget.py

clean:
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis build dist site wheelhop-demo
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/installed: pyproject.toml tools/setup.sh
	tools/setup.sh '.[workbench,logger]'
	touch $@

.venv/installed-test: pyproject.toml tools/setup.sh
	tools/setup.sh '.[test]'
	touch $@
