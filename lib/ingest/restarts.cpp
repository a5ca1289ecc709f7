// Method: the frame counter goes back while host_time continues. The counter began after the frame before it, so it has
// not counted more frames than fit in the time since then; a damaged frame_id has, and a late frame has an earlier
// host_time. If the next line continues the counter of before, the first one was damaged. Only lines before a line
// decide, so that a file gives the same restarts again, complete or growing.
// The clock of the camera continues if it advances like host_time. Otherwise the time stamps after the restart are
// moved so that both clocks advance equally from the last frame before it to the first one after it: a clock table of
// the first start then holds for all, to the delay of host_time.
#include "ingest/restarts.hpp"

#include <algorithm>
#include <cmath>

#include "ingest/clock_checks.hpp"

namespace toliman::ingest {

namespace {

__extension__ using Wide = __int128;
constexpr double kMoreFrames = 1.5; // than fit by the usual step, which may be that of other frames
constexpr double kLongestGap = 4e9; // s, so that sums of times fit

} // namespace

// The largest number of frames that the camera has counted between two lines.
double Restarts::most_between(const SideLine &last, const SideLine &line, double usual_step_ns) noexcept {
    const double gap_s = line.host_s - last.host_s;
    return 1 + (usual_step_ns > 0 ? kMoreFrames * gap_s * 1e9 / usual_step_ns : 0);
}

// Regions of one exposure share its frame id.
bool Restarts::is_restart(const SideLine &last, const SideLine &line, double usual_step_ns) noexcept {
    const double gap_s = line.host_s - last.host_s;
    const bool goes_back = line.frame_id < last.frame_id || (line.frame_id == last.frame_id && line.roi == last.roi);
    if (!(gap_s > 0 && gap_s < kLongestGap) || !goes_back || line.frame_id < 0)
        return false;
    return static_cast<double>(line.frame_id) <= most_between(last, line, usual_step_ns);
}

void Restarts::count(SideLine &line, double usual_step_ns) {
    const auto [entry, is_new] = sessions_.try_emplace(line.session);
    Session &session = entry->second;
    if (!is_new && line.number > 0 && session.last.number == line.number) { // given again, after memory was short
        line.is_restart = session.last.is_restart;
        line.restarts = session.last.restarts;
        line.clock_shift_ns = session.last.clock_shift_ns;
        return;
    }
    if (session.last.is_restart && line.host_s > session.last.host_s &&
        line.frame_id > session.starts.back().before.frame_id &&
        static_cast<double>(line.frame_id) - static_cast<double>(session.last.frame_id) >
            most_between(session.last, line, usual_step_ns)) {
        session.last = session.starts.back().before;
        session.starts.pop_back();
    }
    if (!is_new && is_restart(session.last, line, usual_step_ns)) {
        const SideLine &last = session.last;
        const double gap_s = line.host_s - last.host_s;
        const Wide before = static_cast<Wide>(last.stamp_ns) + last.clock_shift_ns;
        const Wide same = static_cast<Wide>(line.stamp_ns) + last.clock_shift_ns; // if the clock has gone on
        const double advance_s = static_cast<double>(same - before) / 1e9;
        const Wide shift = advances_alike(advance_s, gap_s) ? Wide{last.clock_shift_ns}
                                                            : before + std::llround(gap_s * 1e9) - line.stamp_ns;
        if (shift >= INT64_MIN && shift <= INT64_MAX) {
            session.starts.push_back({line.host_s, last, static_cast<int64_t>(shift)});
            line.is_restart = true;
        }
    }
    // A late frame belongs to the start before it.
    const auto next = std::upper_bound(session.starts.begin(), session.starts.end(), line.host_s,
                                       [](double host_s, const Start &start) { return host_s < start.host_s; });
    line.restarts = static_cast<int64_t>(next - session.starts.begin());
    line.clock_shift_ns = line.restarts > 0 ? (next - 1)->clock_shift_ns : 0;
    if (is_new || line.host_s >= session.last.host_s)
        session.last = line;
}

} // namespace toliman::ingest
