// toliman doctor: checks that this machine is fit to run toliman.
#include <CLI/Version.hpp>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>
#include <zlib.h>

#include "frames/fits.hpp"
#include "options/command.hpp"
#include "scenes/observer_options.hpp"

namespace cli {

namespace {

constexpr double kSlowSync = 50;                                    // ms: 20 records per second with --sync frame
constexpr char kRecord[] = "about as long as a record of a ledger"; // written and fsync'ed
constexpr const char *kSets[] = {"baseline", "avx2", "avx512"};

struct Sync {
    std::string folder;
    double milliseconds = NAN; // median of write + fsync
    std::string error;         // reason if it could not be measured
};

Sync sync_in(const std::string &folder) {
    std::error_code unknown;
    Sync sync;
    sync.folder = std::filesystem::absolute(folder, unknown).lexically_normal().string();
    std::string name = folder + "/toliman-doctor.XXXXXX";
    const int descriptor = ::mkstemp(name.data());
    std::vector<double> times;
    bool good = descriptor >= 0;
    for (int i = 0; good && i < 9; i++) {
        const auto start = std::chrono::steady_clock::now();
        good = ::write(descriptor, kRecord, sizeof kRecord) > 0 && ::fsync(descriptor) == 0;
        times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    if (!good)
        sync.error = std::strerror(errno);
    if (descriptor >= 0) {
        ::close(descriptor);
        ::unlink(name.c_str());
    }
    std::sort(times.begin(), times.end());
    if (good)
        sync.milliseconds = times[times.size() / 2];
    return sync;
}

struct Health {
    toliman_machine machine = toliman::sized<toliman_machine>();
    std::string cpu = processor_name();
    std::vector<std::string> sets; // instruction sets of the CPU
    std::string cfitsio;
    Sync sync;
    std::vector<std::string> problems, warnings;
};

std::string rounded(double value) {
    return formatted(value < 10 ? "%.1f" : "%.0f", value);
}

void find_problems(Health &health) {
    const toliman_machine &machine = health.machine;
    if (toliman_abi_version() != TOLIMAN_ABI_VERSION)
        health.problems.push_back("the program was built for ABI " + std::to_string(TOLIMAN_ABI_VERSION) +
                                  ", libtoliman.so has ABI " + std::to_string(toliman_abi_version()) +
                                  ": install both from the same version");
    if (machine.blas_is_slow != 0)
        health.problems.push_back(std::string("OpenBLAS is slow: it uses ") + machine.blas_core +
                                  " kernels, which are older than this CPU: set OPENBLAS_CORETYPE=" +
                                  machine.blas_better + ", or leave it unset so that this program sets it");
    if (!health.sync.error.empty())
        health.problems.push_back(health.sync.folder + ": cannot be written: " + health.sync.error +
                                  ": give a writable folder");
    if (health.sync.milliseconds > kSlowSync)
        health.problems.push_back("fsync is slow: " + rounded(health.sync.milliseconds) + " ms in " +
                                  health.sync.folder +
                                  ": use track with --sync group, or a state folder on another disk");
    if (health.sets.size() < 2)
        health.warnings.push_back("slow: this CPU has no AVX2; the baseline kernels are several times slower");
#if !defined(__x86_64__)
    health.warnings.push_back("untested: only x86-64 is tested");
#endif
}

Health examine(const std::string &folder) {
    Health health;
    toliman::check(toliman_get_machine(&health.machine));
    for (const char *set : kSets) {
        health.sets.emplace_back(set);
        if (std::strcmp(set, health.machine.isa) == 0)
            break; // the library uses the widest available
    }
    float version = 0;
    cfitsio().get_version(&version);
    health.cfitsio = formatted("%.2f", static_cast<double>(version));
    health.sync = sync_in(folder);
    find_problems(health);
    return health;
}

std::string verdict(const Health &health) {
    if (!health.problems.empty())
        return joined(health.problems, "; ");
    return health.warnings.empty() ? "ready" : "ready, but " + joined(health.warnings, "; ");
}

std::string as_json(const Health &health, const ObserverOptions &observer, const toliman_sky *sky) {
    const toliman_machine &machine = health.machine;
    Json json("schema", "toliman-doctor/1", "version", toliman_version(), "abi_version", toliman_abi_version());
    json.set("cpu", health.cpu, "processors", machine.processors, "isa", machine.isa, "isa_available", health.sets);
    json.set("blas_core", machine.blas_core, "blas_config", machine.blas_config, "blas_threads", machine.blas_threads);
    json.set("blas_is_slow", machine.blas_is_slow != 0);
    json.set("fftw", machine.fftw, "zlib", ::zlibVersion(), "cjson", ::cJSON_Version(), "cfitsio", health.cfitsio,
             "netcdf", toliman_ingest_netcdf_version());
    json.set("cli11", CLI11_VERSION, "fsync_ms", health.sync.milliseconds, "fsync_folder", health.sync.folder);
    observer.set_orbit(json, sky);
    json.set("ready", health.problems.empty(), "verdict", verdict(health));
    return json.text();
}

std::string as_text(const Health &health, const std::string &orbit) {
    const std::string netcdf = toliman_ingest_netcdf_version();
    const toliman_machine &machine = health.machine;
    return formatted("libtoliman   %s, ABI %d\n", toliman_version(), toliman_abi_version()) +
           formatted("CPU          %s, %d processors\n", health.cpu.c_str(), machine.processors) +
           formatted("kernels      %s in use; this CPU has %s\n", machine.isa, joined(health.sets).c_str()) +
           formatted("OpenBLAS     %s kernels, %s; %d thread(s) (%s)\n", machine.blas_core,
                     machine.blas_is_slow != 0 ? "older than the CPU" : "suited to the CPU", machine.blas_threads,
                     machine.blas_config) +
           formatted("FFTW         %s\n", machine.fftw) +
           formatted("libraries    zlib %s, cJSON %s, CFITSIO %s, CLI11 %s, ", ::zlibVersion(), ::cJSON_Version(),
                     health.cfitsio.c_str(), CLI11_VERSION) +
           (netcdf.empty() ? "no netCDF: .nc files cannot be read\n" : "netCDF " + netcdf + "\n") + "fsync        " +
           (health.sync.error.empty() ? rounded(health.sync.milliseconds) + " ms, median of 9," : health.sync.error) +
           " in " + health.sync.folder + (orbit.empty() ? "" : "\nobserver     " + orbit) + "\nverdict      " +
           verdict(health) + "\n";
}

struct DoctorOptions {
    std::string folder = ".";
    ObserverOptions observer;
    bool json = false;
};

void doctor(const DoctorOptions &options, Progress &progress) {
    toliman::sky_predictor sky;
    if (options.observer.is_file())
        sky = options.observer.predictor("alpha-cen", 0, progress);
    const Health health = examine(options.folder.empty() ? "." : options.folder);
    print_stdout(options.json ? as_json(health, options.observer, sky.get())
                              : as_text(health, options.observer.orbit(sky.get())));
    if (!health.problems.empty())
        throw Failure(kExitRejected, "not ready: " + verdict(health));
}

} // namespace

void add_doctor(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "doctor");
    auto options = std::make_shared<DoctorOptions>();
    add_option(command, "FOLDER", options->folder, "");
    options->observer.add_file_to(*command);
    command->add_flag("--json", options->json);
    set_action(*command, context, options, doctor);
}

} // namespace cli
