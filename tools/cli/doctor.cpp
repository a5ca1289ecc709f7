// toliman doctor: what this machine offers.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <unistd.h>

#include "command.hpp"
#include "failure.hpp"
#include "json.hpp"
#include "output.hpp"

namespace cli {

namespace {

// Median milliseconds of write + fsync in the current folder; NaN if it cannot be written.
double fsync_milliseconds() {
    char name[] = "toliman-doctor.XXXXXX";
    const int descriptor = ::mkstemp(name);
    if (descriptor < 0)
        return NAN;
    std::vector<double> times;
    for (int i = 0; i < 9; i++) {
        const auto start = std::chrono::steady_clock::now();
        const bool done = ::write(descriptor, name, sizeof name) > 0 && ::fsync(descriptor) == 0;
        const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
        times.push_back(done ? spent.count() : NAN);
    }
    ::close(descriptor);
    ::unlink(name);
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

void doctor(bool as_json) {
    toliman_machine machine = {};
    machine.struct_size = sizeof machine;
    toliman::check(toliman_get_machine(&machine));
    double gflops = 0;
    toliman::check(toliman_get_blas_speed(&gflops));
    const double fsync = fsync_milliseconds();
    if (as_json) {
        Json json;
        json.set("schema", "toliman-doctor/1").set("version", toliman_version());
        json.set("abi_version", toliman_abi_version()).set("processors", machine.processors);
        json.set("isa", machine.isa).set("blas_core", machine.blas_core).set("blas_config", machine.blas_config);
        json.set("blas_threads", machine.blas_threads).set("blas_is_slow", machine.blas_is_slow);
        json.set("blas_gflops", gflops).set("fftw", machine.fftw).set("fsync_ms", fsync);
        print_stdout(json.text());
        return;
    }
    std::printf("libtoliman   %s, ABI %d\n", toliman_version(), toliman_abi_version());
    std::printf("processors   %d, kernels in use: %s\n", machine.processors, machine.isa);
    std::printf("OpenBLAS     %s kernels, %d thread(s), %.0f GFLOP/s (%s)\n", machine.blas_core, machine.blas_threads,
                gflops, machine.blas_config);
    if (machine.blas_is_slow != 0)
        std::printf("             slow: these kernels are older than the CPU; set OPENBLAS_CORETYPE=%s\n",
                    machine.blas_better);
    std::printf("FFTW         %s\n", machine.fftw);
    std::printf("fsync here   %.2f ms\n", fsync);
    print_stdout("");
}

} // namespace

void add_doctor(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("doctor", "Report CPU, kernels, BLAS speed, fsync latency and versions");
    auto as_json = std::make_shared<bool>(false);
    command->add_flag("--json", *as_json, "as JSON");
    command->callback([&context, as_json] { context.action = [as_json] { doctor(*as_json); }; });
}

} // namespace cli
