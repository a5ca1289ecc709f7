#include "downlink/verdict_text.hpp"

#include <toliman/toliman.hpp>

#include "common/text.hpp"

namespace cli {

namespace {

std::string shape_text(int64_t rows, int64_t cols) {
    return std::to_string(rows) + "x" + std::to_string(cols);
}

std::string rejection_text(const toliman_track_outcome &outcome, const toliman_track_options &settings) {
    const std::string pixel = "pixel " + std::to_string(outcome.row) + ", " + std::to_string(outcome.col);
    switch (outcome.reason) {
    case TOLIMAN_TRACK_REASON_SHAPE:
        return " " + shape_text(outcome.row, outcome.col) + ", must be " + shape_text(settings.rows, settings.cols) +
               ": a new folder takes others by --shape and --crop";
    case TOLIMAN_TRACK_REASON_OVER_RANGE:
        return ", " + pixel + " is " + formatted("%.12g", outcome.pixel) + ", more than --bit-depth allows";
    case TOLIMAN_TRACK_REASON_ZERO_RUN:
        return ", only zeros up to " + pixel;
    case TOLIMAN_TRACK_REASON_NOT_FINITE:
        return " at " + pixel;
    case TOLIMAN_TRACK_REASON_CLOCK:
        return ": no TAI for its time, or too far from time 0 for the periodogram; see --clock and --epoch";
    default:
        return ": no finite value, as it differs too much from frames of the scene or weights";
    }
}

} // namespace

Json frame_line(const toliman_frame *frame, bool has_time, const std::string &place, const char *verdict,
                const char *reason) {
    Json line;
    line.set("schema", "toliman-frame/2");
    if (frame != nullptr)
        line.set("session", frame->session).set("roi", frame->roi).set("frame_id", frame->frame_id);
    else
        line.set("session", nullptr).set("roi", nullptr).set("frame_id", nullptr);
    line.set("verdict", verdict);
    reason != nullptr ? line.set("reason", reason) : line.set("reason", nullptr);
    frame != nullptr &&has_time ? line.set("camera_ns", frame->camera_ns) : line.set("camera_ns", nullptr);
    return std::move(line.set("input", place));
}

std::string verdict_text(const toliman_frame &frame, const toliman_track_outcome &outcome,
                         const toliman_track_options &settings) {
    if (outcome.verdict == TOLIMAN_TRACK_VERDICT_QUARANTINED)
        return "quarantined: frame " + std::to_string(frame.frame_id) + " of session " + frame.session +
               " arrived before with other pixels, time or count of drops; neither copy counts, nor does any later one";
    if (outcome.verdict == TOLIMAN_TRACK_VERDICT_OUTLIER)
        return formatted("outlier: a value of %.4g px, beyond the %.4g px of --value-limit: not in the periodogram",
                         outcome.value, settings.value_limit);
    return std::string("rejected: ") + toliman_track_reason_name(outcome.reason) + rejection_text(outcome, settings);
}

std::string far_text(double value, double sigmas) {
    return formatted(
        "accepted, but its value of %.4g px is %.3g sigma: a strong signal, or damage that hides the period; "
        "a new folder with --value-limit excludes such frames",
        value, sigmas);
}

// A single pair is a difference of clocks that has no ends.
bool is_outside_clock(const toliman_track_options &settings, int64_t camera_ns) noexcept {
    return settings.clock_points > 1 &&
           (camera_ns < settings.clock[0] || camera_ns > settings.clock[2 * settings.clock_points - 2]);
}

std::string warning_line(const std::string &warning, const std::string &input, const std::string &text) {
    Json line;
    line.set("schema", "toliman-track-warning/1").set("warning", warning);
    return line.set("input", input).set("text", text).line();
}

const char *advice_after(const std::exception &error) {
    const auto *failed = dynamic_cast<const toliman::error *>(&error);
    return failed != nullptr && failed->status() == TOLIMAN_E_LOST
               ? "frames printed as accepted may be lost with the ledger: give all frames again"
               : "printed lines are safe on the disk; the same command resumes";
}

} // namespace cli
