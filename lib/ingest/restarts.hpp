// Restarts of the camera within a session: its frame counter begins again, and often its clock, but not the host's.
#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "ingest/side_line.hpp"

namespace toliman::ingest {

class Restarts {
  public:
    // A valid line was read: sets its members restarts, is_restart and clock_shift_ns. usual_step_ns: of the time
    // stamps of the lines before it; 0: unknown.
    void count(SideLine &line, double usual_step_ns);

  private:
    struct Start {
        double host_s;          // of its first frame
        SideLine before;        // the line before it
        int64_t clock_shift_ns; // added to its time stamps, they continue those before it
    };
    struct Session {
        SideLine last;             // by host_time
        std::vector<Start> starts; // of the restarts
    };
    static double most_between(const SideLine &last, const SideLine &line, double usual_step_ns) noexcept;
    static bool is_restart(const SideLine &last, const SideLine &line, double usual_step_ns) noexcept;

    std::map<const char *, Session> sessions_; // by their names, each of which is stored once
};

} // namespace toliman::ingest
