# Front end to CMake: the build is defined in CMakeLists.txt and tools/.
BUILD ?= build
JOBS ?= $(shell nproc)
PREFIX ?= /usr/local
SECONDS ?= 60
CAMPAIGNS = long soak same science missions sky planets doubt camera cosmic core masks chapter budget faults kills fuzz mutants races asan tsan coverage clang arm64 debian13 reproducible
.PHONY: all own deps demo demo-sky check check-deps everything bench record fap noise $(CAMPAIGNS) abi docs install package wheel release-files format lint clean help

all: own deps $(BUILD)/build.ninja ## build the library and the program (default)
	@cmake --build $(BUILD) --parallel $(JOBS)
demo: all ## build everything, find a planet in 1095 simulated frames, and draw a report
	$(BUILD)/bin/toliman run examples/scenes/chapter.json
	$(BUILD)/bin/toliman report chapter.run
demo-sky: all ## draw a mission that nobody has seen, find its planet with three commands, print the truth (3 minutes)
	examples/sky/demo.sh sky.run --seed 2
check: everything ## build and run the tests
	tests/with_kernels $(BUILD) ctest --test-dir $(BUILD) --label-exclude long --output-on-failure --parallel $$(($(JOBS) + 1)) # some tests wait for disks and clocks
bench: everything ## measure speed and error, with reference programs, into build/bench and a report (40 minutes)
	@/usr/bin/python3 tools/bench/bench.py $(BUILD)/bin $(BUILD)/bench
	@$(BUILD)/bin/toliman report $(BUILD)/bench
bench-%: everything ## run one benchmark, with details: sim, cae, period, weights, fit, calibrate, commands, growth or size
	@/usr/bin/python3 tools/bench/bench.py $(BUILD)/bin $(BUILD)/bench $*
record: bench ## run make bench and write its results to tools/bench/recorded.json and the tables of the documents
	@/usr/bin/python3 tools/bench/record.py $(BUILD)/bench
fap: everything ## count false alarms in noise, and samples until a signal is found (2 minutes)
	@$(BUILD)/bin/bench_fap
noise: everything ## count false alarms in correlated noise, with and without its model (half an hour)
	@$(BUILD)/bin/bench_noise

long: everything ## run all tests, also those of tools/check and of the packages (20 minutes)
soak: everything ## run for long: a million frames, kills, power cuts, frames out of order, round trips (10 minutes)
same: everything ## compare results over instruction sets, workers, OpenBLAS kernels and 20 orders (1 minute)
science: everything ## find the separation with unknown optics, and of stars that move: bias and efficiency; false alarms with nuisance functions (20 minutes)
missions: everything ## search the planet of alpha Centauri in 600 simulated missions, blind: shares found, false alarms; aliases (10 minutes)
sky: everything ## find the planets of 40 missions that nobody has seen, from the downlink, with three commands (2 hours)
planets: everything ## compare posteriors, odds and limits of planets with 1,800 simulated series (1 hour)
doubt: everything ## search planets in frames with effects that the model lacks, and in 2,400 series with wrong sigmas, times, units and samples (20 minutes)
camera: everything ## calibrate unknown detectors from their own frames in six missions, with and without a planet; the response of 65,536 pixels (1 hour)
cosmic: everything ## compare periods of 1,000 frames with and without hits of cosmic rays (5 minutes)
core: everything ## compare network, template and fit in windows of 128x128 pixels, with and without an Earth (8 minutes)
masks: everything ## design masks for three scenes; what they tolerate; fresh frames with them, 20 seeds (40 minutes)
chapter: everything ## train the network as the chapter does, 1,000 epochs at three amplitudes; smoothness in time (3 hours)
budget: everything ## compare the error budget of the mission with finite differences of images (2 minutes)
faults: everything ## call every public function while each allocation and file operation fails in turn (10 minutes)
kills: everything ## kill every long command, 950 times in all: half results, lost frames, time to finish (1 hour)
fuzz: check-deps ## mutate the input of every parser with libFuzzer and sanitizers, SECONDS (60) each
mutants: check-deps ## change lib one line at a time and count the changes that no test sees, 40 per module (1 hour)
races: check-deps ## run 8 threads with 10,000 objects each under ThreadSanitizer, in a host that plans FFTs (10 minutes)
asan tsan: check-deps ## run every test under AddressSanitizer and UBSan, or ThreadSanitizer (half an hour)
clang: check-deps ## build with clang instead of gcc and run the tests (20 minutes)
arm64: everything ## cross-compile for arm64 and run the tests in an emulated Debian, as root (4 hours)
debian13: ## build and run the tests in a Debian 13 of its own, as root (half an hour)
reproducible: check-deps ## make the files of a release twice, in other folders and settings, and compare their bytes (20 minutes)
coverage: check-deps ## run the tests and list the lines and branches of lib/ that they do not reach (15 minutes)
$(CAMPAIGNS):
	@SECONDS_EACH=$(SECONDS) tests/campaign $@ $(BUILD) $(JOBS)

abi: check-deps ## record additions to the binary interface in tests/abi, refuse what breaks callers
	@tools/check/abi --record
docs: all check-deps ## generate the reference of the C interface and the gallery in Python: build/docs/html, build/docs/python
	@tools/docs/make $(BUILD)/docs $(BUILD)
install: all ## install below PREFIX, by default /usr/local; prepend DESTDIR
	@cmake --install $(BUILD) --prefix $(PREFIX)
package: all check-deps ## build Debian packages in build/packages
	@cpack --config $(BUILD)/CPackConfig.cmake
wheel: all check-deps ## build a wheel of the Python package that contains the library, in build
	@tools/cmake/wheel $(BUILD)/lib/libtoliman.so $(BUILD)/python $(BUILD)
release-files: all check-deps ## make the files of a release from the commit that is checked out, into build/release
	@tools/release/files $(BUILD) $(BUILD)/release
format: check-deps ## format the sources with clang-format
	@tools/check/format --write
lint: check-deps ## run cppcheck and clang-tidy on the library and the programs
	@tools/check/lint $(JOBS)
clean: ## remove the build folder
	rm -rf $(BUILD)
help: ## list the targets
	@grep -hE '^[a-z% -]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

own: ; @tools/cmake/own $(BUILD)
deps: ; @tools/deps/install build
check-deps: ; @tools/deps/install check
everything: own check-deps
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=ON >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS)
$(BUILD)/build.ninja:
	@cmake -S . -B $(BUILD) -G Ninja -DTOLIMAN_TESTS=OFF >/dev/null
