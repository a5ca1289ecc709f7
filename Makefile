# Thin front to CMake: everything real lives in CMakeLists.txt and tools/.
BUILD ?= build
JOBS ?= $(shell nproc)
PREFIX ?= /usr/local
PYTHON = /usr/bin/python3

.DEFAULT_GOAL := all
.PHONY: all deps demo check check-deps benches bench-sim bench-cae bench-period bench-weights fap soak install format lint
.PHONY: clean help

all: deps $(BUILD)/build.ninja ## build the library and the program (default)
	@cmake --build $(BUILD) --parallel $(JOBS)

demo: all ## build everything and find a planet in 1095 simulated frames
	$(BUILD)/bin/toliman run examples/scenes/chapter.json

check: check-deps ## build and run every test
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=ON >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS)
	ctest --test-dir $(BUILD) --output-on-failure --parallel $(JOBS)

bench-sim: benches ## measure the simulator's speed against its error (3 minutes)
	@$(PYTHON) tests/bench/bench_sim.py $(BUILD)/bin $(BUILD)/bench-sim.json

bench-cae: benches ## measure the autoencoder against the processor's peak, PyTorch and oneDNN (1 minute)
	@$(PYTHON) tests/bench/bench_cae.py $(BUILD)/bin $(BUILD)/bench-cae.json

bench-period: benches ## measure the periodograms' speed against their error and astropy's (1 minute)
	@$(PYTHON) tests/bench/bench_period.py $(BUILD)/bin $(BUILD)/bench-period.json

bench-weights: benches ## measure the weights file's bytes against what they are worth (1 minute)
	@$(PYTHON) tests/bench/bench_weights.py $(BUILD)/bin

fap: benches ## count the false alarms of noise, and the samples until a signal is found (2 minutes)
	@$(BUILD)/bin/bench_fap

soak: benches ## track a million frames; 200 kills, 20,000 power cuts, 10,000 passes out of order (5 minutes)
	@$(BUILD)/bin/bench_track
	@TOLIMAN_KILLS=200 $(BUILD)/bin/test_track_folder
	@TOLIMAN_POWER_CUTS=20000 $(BUILD)/bin/test_power_cut
	@TOLIMAN_SEEDS=10000 $(BUILD)/bin/test_track_order

install: all ## install below PREFIX, by default /usr/local
	@cmake --install $(BUILD) --prefix $(PREFIX)

format: ## lay out the sources as .clang-format says
	@git ls-files '*.c' '*.h' '*.cpp' '*.hpp' | xargs clang-format -i

lint: check-deps $(BUILD)/build.ninja ## clang-tidy over the library and the program
	@git ls-files 'lib/*.cpp' 'tools/*.cpp' | xargs -P $(JOBS) -n 4 clang-tidy -p $(BUILD) --quiet

clean: ## remove what was built
	rm -rf $(BUILD)

help: ## say what can be made
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

deps:
	@tools/deps/install build

check-deps:
	@tools/deps/install check

benches: check-deps
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=ON >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS)

$(BUILD)/build.ninja:
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=OFF >/dev/null
