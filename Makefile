# demo and test make their own environment in .venv from requirements.lock; once made, it needs no network.
VENV := .venv
BIN := $(VENV)/bin
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && echo $$p && break; done)
# named after what went in, so a touched file installs nothing again and a changed one does
INSTALLED := $(VENV)/installed-$(shell cat requirements.lock pyproject.toml | cksum | cut -d' ' -f1)
BENCH := $(VENV)/installed-bench-$(shell cat requirements-bench.lock | cksum | cut -d' ' -f1)

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
	$(BIN)/gen-art bench

gallery: $(INSTALLED)
	$(BIN)/gen-art gallery

# the documentation site, in site/: open site/index.html. A broken link or reference is an error
docs: $(INSTALLED)
	$(BIN)/python docs/make_site.py

$(INSTALLED): | requirements.lock pyproject.toml
	@test -n "$(PYTHON)" || { echo "gen-art needs Python 3.11, 3.12 or 3.13; name one: make PYTHON=/path/to/python3.12" >&2; exit 2; }
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

$(BENCH): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-bench.lock
	@touch $@

# needs uv; universal: one file for Linux, macOS and Windows, Python 3.11 to 3.13, and no index address in it
COMPILE := uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url --custom-compile-command "make lock"
lock:
	$(COMPILE) --extra dev pyproject.toml -o requirements.lock
	$(COMPILE) --extra bench -c requirements.lock pyproject.toml -o requirements-bench.lock

clean:
	rm -rf $(VENV) out build dist site
