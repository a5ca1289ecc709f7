// Method: a child process reads the file and tells by its end whether that was possible, so that one damaged file does
// not end a run of many. netCDF is loaded before, once for all children.
#include "frames/batch_probe.hpp"

#include <cerrno>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"

namespace cli {

namespace {

[[noreturn]] void read_and_exit(const std::string &path) noexcept {
    const rlimit no_core = {0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    const int null = ::open("/dev/null", O_WRONLY);
    ::dup2(null, STDERR_FILENO); // what the C library says of a damaged heap
    auto options = toliman::sized<toliman_ingest_options>();
    options.pixel = TOLIMAN_PIXEL_U16;
    toliman_ingest *reader = nullptr;
    toliman_status status = toliman_ingest_create(path.c_str(), &options, &reader);
    auto event = toliman::sized<toliman_ingest_event>();
    while (status == TOLIMAN_OK && event.event != TOLIMAN_INGEST_EVENT_NOTHING) {
        auto frame = toliman::sized<toliman_frame>();
        event = toliman::sized<toliman_ingest_event>();
        status = toliman_ingest_next(reader, &frame, &event);
    }
    ::_exit(0);
}

} // namespace

void probe_batch(const std::string &path) {
    if (toliman_ingest_netcdf_version()[0] == '\0')
        return;
    const pid_t child = ::fork();
    if (child == 0)
        read_and_exit(path);
    int status = 0;
    while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR)
        ;
    if (child > 0 && WIFSIGNALED(status))
        malformed(path, "is damaged: netCDF crashes on it");
}

} // namespace cli
