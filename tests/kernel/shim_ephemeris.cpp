// C interface to the files of an observer, for the test.
#include <cstdio>
#include <memory>
#include <string>

#include "ingest/epoch.hpp"
#include "sky/segment_builder.hpp"

using namespace toliman;

namespace {

std::unique_ptr<sky::Ephemeris> ephemeris;
std::string message, warning;

ingest::LeapSeconds leap_seconds() {
    return ingest::LeapSeconds(erfa::leap_seconds().rows);
}

template <class Work> int32_t status_of(Work work) {
    try {
        message = "";
        work();
        return 0;
    } catch (const Error &error) {
        message = error.what();
        return static_cast<int32_t>(error.status());
    }
}

} // namespace

extern "C" {

const char *shim_message(void) {
    return message.c_str();
}

const char *shim_warning(void) {
    return warning.c_str();
}

int32_t shim_read_ephemeris(const char *path) {
    Log log;
    log.call = [](int32_t, const char *text, void *) { warning += text; };
    warning = "";
    return status_of(
        [&] { ephemeris = std::make_unique<sky::Ephemeris>(sky::read_ephemeris(path, leap_seconds(), log)); });
}

// Position in m and velocity in m/s of the file that was read last.
int32_t shim_ephemeris_at(int64_t tai_ns, double *state) {
    return status_of([&] {
        const sky::State found = ephemeris->at(tai_ns);
        for (size_t k = 0; k < 3; k++) {
            state[k] = found.position_m[k];
            state[3 + k] = found.velocity_m_s[k];
        }
    });
}

size_t shim_segments(void) {
    return ephemeris->segments().size();
}

// Number of states; times of the first one, and the usable ones.
size_t shim_segment(size_t segment, int64_t times[3]) {
    const sky::Segment &found = ephemeris->segments().at(segment);
    times[0] = found.tai_ns.front();
    times[1] = found.first_ns;
    times[2] = found.last_ns;
    return found.states.size();
}

// Checks states {t_s, x, y, z, vx, vy, vz} in s, m and m/s, without a file.
int32_t shim_check_states(const double *states, size_t count) {
    return status_of([&] {
        sky::SegmentBuilder builder("states", 0, {});
        for (size_t i = 0; i < count; i++) {
            const double *const from = states + 7 * i;
            builder.add(static_cast<int64_t>(from[0] * 1e9), {{from[1], from[2], from[3]}, {from[4], from[5], from[6]}},
                        static_cast<int>(i));
        }
        builder.finish({});
    });
}

void shim_date_text(int64_t tai_ns, char *text, size_t capacity) {
    std::snprintf(text, capacity, "%s", ingest::date_text(tai_ns).c_str());
}
}
