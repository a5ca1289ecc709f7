// Files of an observer: Orbit Ephemeris Messages and tables.
#include <cmath>
// promise: parsers-are-safe

#include "fuzz.hpp"
#include "memory_file.hpp"
#include "sky/ephemeris.hpp"
#include "sky/segment_builder.hpp"

using namespace fuzz;
using namespace toliman;

namespace {

constexpr int kSeconds = 120; // between states

// Eight states of a circular orbit of 7000 km, in km, from the state `first` on.
std::string states(int first, bool message) {
    std::string all;
    for (int i = first; i < first + 8; i++) {
        constexpr double kRadius = 7000, kMotion = 0.00107801;
        const double angle = kMotion * kSeconds * i, speed = kRadius * kMotion;
        char line[200];
        std::snprintf(line, sizeof line,
                      message ? "2028-01-01T00:%02d:00 %.3f %.3f 0 %.6f %.6f 0\n"
                              : "2028-001T00:%02d:00,%.3f,%.3f,0,%.6f,%.6f,0\n",
                      i * kSeconds / 60, kRadius * std::cos(angle), kRadius * std::sin(angle), -speed * std::sin(angle),
                      speed * std::cos(angle));
        all += line;
    }
    return all;
}

std::string segment(const char *start, const char *stop, const char *more) {
    return std::string("META_START\nOBJECT_NAME = S\nOBJECT_ID = 2028-1A\nCENTER_NAME = EARTH\nREF_FRAME = GCRF\n"
                       "TIME_SYSTEM = UTC\nSTART_TIME = 2028-001T") +
           start + "\nSTOP_TIME = 2028-01-01T" + stop + "Z\n" + more + "META_STOP\n";
}

// A time in each segment has a state, or none where states are too far apart.
void require_states(const sky::Ephemeris &ephemeris, int64_t tai_ns) {
    try {
        const sky::State state = ephemeris.at(tai_ns);
        for (size_t k = 0; k < 3; k++)
            require(std::isfinite(state.position_m[k]) && std::isfinite(state.velocity_m_s[k]), "an infinite state");
    } catch (const Error &error) {
        require(error.status() == Status::range, error.what());
    }
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    const std::string header = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2028\nORIGINATOR = O\n";
    const std::string first =
        segment("00:00:00", "00:14:00", "USEABLE_START_TIME = 2028-01-01T00:01:00\nINTERPOLATION = HERMITE\n");
    const std::string covariance = "COVARIANCE_START\nEPOCH = 2028\n1\nCOVARIANCE_STOP\n";
    return {bytes_of(header + first + states(0, true) + covariance),
            bytes_of(header + first + states(0, true) + segment("00:14:00", "00:28:00", "") + states(7, true)),
            bytes_of("t_utc,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s # O\n" + states(0, false)),
            bytes_of("x_m,y_m,z_m,t_tai_ns,vx_m_s,vy_m_s,vz_m_s\n1e8,0,0,1,1,0,0\n1e8,0,0,2,1,0,0\n1e8,0,0,3,1,0,0\n"
                     "1e8,0,0,4,1,0,0\n1e8,0,0,5,1,0,0\n1e8,0,0,6,1,0,0\n1e8,0,0,7,1,0,0\n1e8,0,0,8,1,0,0\n")};
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const ingest::LeapSeconds leap_seconds(erfa::leap_seconds().rows);
    if (size == 0)
        return 0;
    const std::string path = path_of(std::string(reinterpret_cast<const char *>(data), size));
    try {
        const sky::Ephemeris ephemeris = sky::read_ephemeris(path, leap_seconds, {});
        require(!ephemeris.segments().empty(), "no segment");
        int64_t before = INT64_MIN;
        for (const sky::Segment &found : ephemeris.segments()) {
            require(found.states.size() >= 8 && found.tai_ns.size() == found.states.size(), "too few states");
            require(found.first_ns >= before && found.last_ns > found.first_ns, "segments that overlap");
            require(found.first_ns >= found.tai_ns.front() && found.last_ns <= found.tai_ns.back(), "no states there");
            before = found.last_ns;
            for (size_t i = 0; i + 1 < found.tai_ns.size(); i++) {
                require(found.tai_ns[i] < found.tai_ns[i + 1], "times that do not increase");
                require_states(ephemeris, found.tai_ns[i] + (found.tai_ns[i + 1] - found.tai_ns[i]) / 2);
            }
            require_states(ephemeris, found.first_ns);
            require_states(ephemeris, found.last_ns);
        }
        fuzz::accepted++;
    } catch (const Error &error) {
        require(error.status() == Status::format && std::string(error.what()).find(path) == 0, error.what());
    }
    return 0;
}
