# `make serve` runs Asperity, `make test` checks it; both set everything up first.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: setup serve test lint audit browser clean

setup: .venv/installed

.venv/installed: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("Asperity needs Python 3.11 or later; set PYTHON=") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --upgrade pip
	$(BIN)/pip install --quiet --editable '.[dev]'
	touch $@

serve: setup
	$(BIN)/asperity serve

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Fails on a known vulnerability of what is installed, not where nobody can be asked.
audit: setup
	@$(BIN)/pip-audit --progress-spinner off --skip-editable >.venv/audit.txt 2>&1; head -n 1 .venv/audit.txt
	@! grep -Eq '^Found [0-9]+ known vulnerabilit' .venv/audit.txt

test: lint browser
	$(BIN)/pytest

# The page is tested in Debian's Chromium. Without it, and without the right to install it, those tests are skipped.
browser:
	@command -v chromium >/dev/null || { \
	  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; \
	  then apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium fonts-dejavu-core >/dev/null; \
	  else echo 'Chromium is not installed: the tests of the web page will be skipped.'; fi; }

clean:
	rm -rf .venv
