# demo and test make their own environment in .venv from requirements.lock; once made, it needs no network.
VENV := .venv
BIN := $(VENV)/bin
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && echo $$p && break; done)
# named after what went in, so a touched file installs nothing again and a changed one does
INSTALLED := $(VENV)/installed-$(shell cat requirements.lock pyproject.toml | cksum | cut -d' ' -f1)
# numba, with which gen-art is compared, needs older versions of some packages: an environment of its own
BENCH := .venv-bench/installed-$(shell cat requirements-bench.lock pyproject.toml | cksum | cut -d' ' -f1)

.PHONY: demo test proofs verdicts check golden bench gallery docs lock clean

demo: $(INSTALLED)
	@mkdir -p out
	@$(BIN)/gen-art still fire --time 2 -o out/fire.png --overwrite
	@$(BIN)/gen-art render fire -o out/fire.mp4 --overwrite

test: $(INSTALLED)
	$(BIN)/python -m pytest -m "not proof" --numprocesses 2 --dist worksteal

proofs: $(INSTALLED)
	$(BIN)/python -m pytest -m proof --numprocesses 2

# checks what every shipped preset expects, and keeps the verdicts that their pictures carry
verdicts: $(INSTALLED)
	$(BIN)/gen-art check

check: $(INSTALLED)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/lint-imports
	$(BIN)/mypy
	$(BIN)/python docs/check_links.py

# draws the golden pictures of tests/golden anew, and the old beside the new in out/golden.png
golden: $(INSTALLED)
	$(BIN)/python -m tests.golden

bench: $(BENCH)
	.venv-bench/bin/gen-art bench

gallery: $(INSTALLED)
	$(BIN)/gen-art gallery

# the documentation site, in site/: open site/index.html. A broken link or reference is an error
docs: $(INSTALLED)
	$(BIN)/python docs/make_site.py

CHECK_PYTHON := test -n "$(PYTHON)" || { echo "gen-art needs Python 3.11, 3.12 or 3.13; name one: make PYTHON=/path/to/python3.12" >&2; exit 2; }

# $(1): folder of the environment, $(2): file that pins its packages
define ENVIRONMENT
@$(CHECK_PYTHON)
$(PYTHON) -m venv --clear $(1)
$(1)/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $(2)
$(1)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
@touch $@
endef

$(INSTALLED): | requirements.lock pyproject.toml
	$(call ENVIRONMENT,$(VENV),requirements.lock)

$(BENCH): | requirements-bench.lock pyproject.toml
	$(call ENVIRONMENT,.venv-bench,requirements-bench.lock)

# needs uv; universal: one file for Linux, macOS and Windows, Python 3.11 to 3.13, and no index address in it
COMPILE := uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url --custom-compile-command "make lock"
lock:
	$(COMPILE) --extra dev pyproject.toml -o requirements.lock
	$(COMPILE) --extra bench pyproject.toml -o requirements-bench.lock

clean:
	rm -rf $(VENV) .venv-bench out build dist site
