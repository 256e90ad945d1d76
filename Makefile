# `make demo` and `make test` are all a user needs; `make help` lists the rest.
# Everything lands in .venv/, out/, cnc_front/_native.abi3.so and Cargo's target directory; `make clean` removes it.
#
#   PYTHON=python3.12 make demo     another interpreter (3.11 or later)
#   CARGO_TARGET_DIR=... make demo  another place for Cargo's output

.SUFFIXES:
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
MAKEFLAGS += --no-builtin-rules --no-print-directory

GOALS := demo test lint conformance bench check clean help
.PHONY: $(GOALS) toolchain

HERE := $(shell list='$(MAKEFILE_LIST)'; dirname -- "$${list# }")
ifneq ($(HERE),.)
# called from elsewhere with -f: every path below is relative to the checkout (which may have blanks in its name)
$(GOALS):
	@$(MAKE) -C '$(HERE)' $@
else

export PATH := $(PATH):$(HOME)/.cargo/bin
# property tests draw the same cases every time; another seed explores: make test PROPTEST_RNG_SEED=7 HYPOTHESIS_PROFILE=explore
export PROPTEST_RNG_SEED ?= 1
# what is run here stays out of the user's own history
export CNC_FRONT_HISTORY ?= out/history.sqlite
PY := .venv/bin/python
NATIVE := cnc_front/_native.abi3.so
RUST := Cargo.toml Cargo.lock $(shell find motion_kernel gcode toolpaths cnc_front \( -name '*.rs' -o -name Cargo.toml \))
OURS := pyproject.toml $(shell find cnc_front gcode motion_kernel toolpaths tui tests examples benches -type f \
	! -path '*/__pycache__/*' ! -path '*/target/*' ! -name '*.so' ! -name '* *')

help:
	@echo 'make demo         build all, dry-run examples/jobs/bracket.nc to a verdict, a report and a recording'
	@echo 'make test         every test: cargo test --workspace, pytest'
	@echo 'make lint         ruff, mypy, rustfmt, clippy'
	@echo 'make conformance  how many rows of the manual a passing test shows (tests/conformance)'
	@echo 'make bench        speed figures beside a reference loop and beside peers that are installed (benches)'
	@echo 'make check        test, lint and conformance: what .ci/run does'
	@echo 'make clean        remove all that was built'

demo: $(NATIVE)
	@mkdir -p out/demo
	$(PY) -m cnc_front run examples/jobs/bracket.nc --record out/demo/bracket.mcap --report out/demo/report

test: $(NATIVE) .venv/.dev
	@mkdir -p out/test
	@failed=; \
	$(PY) -m tests.conformance.cargo out/test/rust.json || failed="$$failed cargo-test"; \
	$(PY) -m pytest -n auto --results=out/test/python.json || failed="$$failed pytest"; \
	if [ -n "$$failed" ]; then echo "make test: failed:$$failed" >&2; exit 1; else echo 'make test: all passed'; fi

lint: .venv/.dev
	@cargo clippy --version >/dev/null 2>&1 && cargo fmt --version >/dev/null 2>&1 || \
	{ echo 'make: clippy or rustfmt is missing; run: rustup component add clippy rustfmt' >&2; exit 1; }
	@failed=; \
	$(PY) -m ruff check . || failed="$$failed ruff-check"; \
	$(PY) -m ruff format --check . || failed="$$failed ruff-format"; \
	$(PY) -m mypy || failed="$$failed mypy"; \
	cargo fmt --all --check || failed="$$failed rustfmt"; \
	PYO3_PYTHON="$$PWD/$(PY)" cargo clippy --workspace --all-targets --locked --quiet -- -D warnings || failed="$$failed clippy"; \
	if [ -n "$$failed" ]; then echo "make lint: failed:$$failed" >&2; exit 1; else echo 'make lint: clean'; fi

# reads what the last `make test` left; runs the tests again only where a source is newer
conformance: out/test/rust.json out/test/python.json
	@$(PY) -m tests.conformance out/test/rust.json out/test/python.json

out/test/rust.json: $(RUST) | .venv/.dev
	@mkdir -p out/test
	-@$(PY) -m tests.conformance.cargo $@

out/test/python.json: $(OURS) $(NATIVE) | .venv/.dev
	@mkdir -p out/test
	-@$(PY) -m pytest -n auto --results=$@

bench: $(NATIVE)
	@$(PY) -m benches
	@$(PY) -m benches.peer
	@$(PY) -m benches.sympas
	@$(PY) -m benches.terminal
	@cargo bench --quiet --locked -p motion_kernel --bench samples --bench planning

check:
	@.ci/run

clean:
	rm -rf .venv out target dist .pytest_cache .mypy_cache .ruff_cache .hypothesis $(NATIVE)
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# ---- set-up: one stamp a step, so that nothing is done twice

toolchain:
	@command -v cargo >/dev/null && cargo --version >/dev/null 2>&1 || { echo 'make: no Rust toolchain found; install one from https://rustup.rs (or your distribution, 1.85 or later) and run make again' >&2; exit 1; }

.venv/.run: constraints.txt pyproject.toml | toolchain
	@set -e; for p in $(or $(PYTHON),python3 python3.14 python3.13 python3.12 python3.11 python); do \
	  if "$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; then python=$$p; break; fi; done; \
	[ -n "$$python" ] || { echo 'make: Python 3.11 or later is needed; install it, or name it: make PYTHON=/path/to/python3.11' >&2; exit 1; }; \
	[ -x $(PY) ] && $(PY) -c '' 2>/dev/null || "$$python" -m venv --clear .venv || \
	{ echo "make: $$python cannot make virtual environments; install its venv package (Debian, Ubuntu: apt install python3-venv)" >&2; exit 1; }
	@echo 'make: installing Python packages into .venv'
	@$(PY) .ci/requirements.py build run > .venv/run.txt
	@$(PY) -m pip install --quiet --disable-pip-version-check -c constraints.txt -r .venv/run.txt
	@touch $@

.venv/.dev: .venv/.run
	@echo 'make: installing test tools into .venv'
	@$(PY) .ci/requirements.py dev > .venv/dev.txt
	@$(PY) -m pip install --quiet --disable-pip-version-check -c constraints.txt -r .venv/dev.txt
	@touch $@

# the compiled module is installed editable, so that a checkout never runs a stale copy of its own Python files
$(NATIVE): .venv/.run $(RUST) pyproject.toml
	@echo 'make: building the Rust extension in release mode (a minute or two the first time)'
	@env -u CONDA_PREFIX VIRTUAL_ENV="$$PWD/.venv" PIP_QUIET=1 $(PY) -m maturin develop --release --locked --quiet
	@touch $@

endif
