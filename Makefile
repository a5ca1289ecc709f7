# Thin front to CMake: everything real lives in CMakeLists.txt and tools/.
BUILD ?= build
JOBS ?= $(shell nproc)
PREFIX ?= /usr/local
PYTHON = /usr/bin/python3

.DEFAULT_GOAL := all
.PHONY: all deps demo check check-deps everything fap soak fuzz abi install package format lint clean help

all: deps $(BUILD)/build.ninja ## build the library and the program (default)
	@cmake --build $(BUILD) --parallel $(JOBS)

demo: all ## build everything and find a planet in 1095 simulated frames
	$(BUILD)/bin/toliman run examples/scenes/chapter.json

check: everything ## build and run every test
	ctest --test-dir $(BUILD) --output-on-failure --parallel $(JOBS)

bench-%: everything ## measure: sim, cae, period against their errors and others; weights; size, ldd, loading (minutes)
	@$(PYTHON) tests/bench/bench_$*.py $(BUILD)/bin $(BUILD)/bench-$*.json

fap: everything ## count the false alarms of noise, and the samples until a signal is found (2 minutes)
	@$(BUILD)/bin/bench_fap

soak: everything ## track a million frames; 200 kills, 20,000 power cuts, 10,000 passes out of order (5 minutes)
	@$(BUILD)/bin/bench_track
	@TOLIMAN_KILLS=200 $(BUILD)/bin/test_track_folder
	@TOLIMAN_POWER_CUTS=20000 $(BUILD)/bin/test_power_cut
	@TOLIMAN_SEEDS=10000 $(BUILD)/bin/test_track_order

SECONDS ?= 60
fuzz: check-deps ## mutate inputs of every parser, by clang's libFuzzer and sanitizers, SECONDS (60) each
	@cmake --preset fuzz >/dev/null
	@cmake --build build-fuzz --parallel $(JOBS) --target toliman_fuzz
	@tests/fuzz/run build-fuzz $(SECONDS)

abi: check-deps ## record in tests/abi what is new in the binary interface; refuses what breaks its callers
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=ON >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS) --target toliman_abi
	@tools/check/abi --record $(BUILD)/lib/libtoliman_abi.so

install: all ## install below PREFIX, by default /usr/local; DESTDIR stands before it
	@cmake --install $(BUILD) --prefix $(PREFIX)

package: all check-deps ## make Debian packages in build/packages
	@cpack --config $(BUILD)/CPackConfig.cmake

format: ## lay out the sources as .clang-format says
	@git ls-files '*.c' '*.h' '*.cpp' '*.hpp' | xargs clang-format -i

lint: check-deps $(BUILD)/build.ninja ## clang-tidy over the library and the program
	@git ls-files 'lib/*.cpp' 'tools/*.cpp' | xargs -P $(JOBS) -n 4 clang-tidy -p $(BUILD) --quiet

clean: ## remove what was built
	rm -rf $(BUILD)

help: ## say what can be made
	@grep -hE '^[a-z%-]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

deps:
	@tools/deps/install build

check-deps:
	@tools/deps/install check

everything: check-deps
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=ON >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS)

$(BUILD)/build.ninja:
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=OFF >/dev/null
