# Thin front to CMake: everything real lives in CMakeLists.txt and tools/.
BUILD ?= build
JOBS ?= $(shell nproc)
PREFIX ?= /usr/local
PYTHON = /usr/bin/python3

.DEFAULT_GOAL := all
.PHONY: all deps demo check check-deps everything fap soak same races abi install package format lint clean help

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

soak: everything ## a million frames; 200 kills, 20,000 power cuts, 10,000 passes, 10^6 objects, storms (10 minutes)
	@$(BUILD)/bin/bench_track
	@TOLIMAN_KILLS=200 $(BUILD)/bin/test_track_folder
	@TOLIMAN_POWER_CUTS=20000 $(BUILD)/bin/test_power_cut
	@TOLIMAN_SEEDS=10000 $(BUILD)/bin/test_track_order
	@TOLIMAN_OBJECTS=1000000 $(BUILD)/bin/test_round_trips
	@TOLIMAN_STORMS=2000 $(BUILD)/bin/test_not_finite
	@TOLIMAN_LIBRARY=$(BUILD)/lib/libtoliman.so $(PYTHON) tests/bench/long_stream.py

check-%: check-deps ## every test in a build with sanitizers, asan-ubsan or tsan (half an hour)
	@cmake --preset $* -DTOLIMAN_TESTS=ON >/dev/null
	@cmake --build build-$(firstword $(subst -, ,$*)) --parallel $(JOBS)
	ctest --test-dir build-$(firstword $(subst -, ,$*)) --output-on-failure --parallel $(JOBS)

races: check-deps ## 8 threads of 10,000 objects each under ThreadSanitizer, in a host that plans FFTs (10 minutes)
	@cmake --preset tsan -DTOLIMAN_TESTS=ON >/dev/null
	@cmake --build build-tsan --parallel $(JOBS) --target same_threads
	@build-tsan/bin/same_threads 10000

same: everything ## compare results over instruction sets, workers, OpenBLAS kernels and 20 orders (1 minute)
	@TOLIMAN_RESULTS=$(BUILD)/bin/same_results TOLIMAN_ORDERS=20 $(PYTHON) tests/same/test_results.py

faults: everything ## call every public function while each allocation and each call on files fails it (10 minutes)
	@for what in memory files; do \
	GLIBC_TUNABLES=glibc.malloc.perturb=165 $(BUILD)/bin/faults lib/api/toliman.sym $$what all || exit 1; done

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

coverage: check-deps ## run the tests and say which lines and branches of lib/ they leave out (15 minutes)
	@cmake --preset coverage >/dev/null
	@cmake --build build-coverage --parallel $(JOBS)
	@tools/check/coverage build-coverage $(JOBS)

lint: check-deps $(BUILD)/build.ninja ## cppcheck and clang-tidy over the library and the program
	@cppcheck --quiet --error-exitcode=1 --enable=warning,performance,portability --std=c++17 --language=c++ \
	    --suppressions-list=tools/check/cppcheck.txt -Ilib -Iinclude -I$(BUILD)/include -I$(BUILD)/tools/cli \
	    -D__x86_64__=1 -DTOLIMAN_ISA=baseline '-D__attribute__(x)=' lib tools/cli tools/mpi
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
