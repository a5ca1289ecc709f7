// Converts outcomes, records, columns, streams and counts of a tracker to the public structs.
#pragma once
#include <cstdint>

#include <toliman/track.h>
#include <toliman/track_records.h>

#include "api/choice.hpp"
#include "api/goodness.hpp"
#include "api/members.hpp"
#include "api/output.hpp"
#include "base/name.hpp"
#include "track/tracker.hpp"

namespace toliman::api {

constexpr Choice<track::Verdict> kVerdicts = {TOLIMAN_TRACK_VERDICT_ACCEPTED, TOLIMAN_TRACK_VERDICT_REJECTED,
                                              "TOLIMAN_TRACK_VERDICT_..."};
constexpr Choice<track::Reason> kReasons = {TOLIMAN_TRACK_REASON_NONE, TOLIMAN_TRACK_REASON_NO_INTERVALS,
                                            "TOLIMAN_TRACK_REASON_..."};
constexpr Choice<track::Reason> kRejections = {TOLIMAN_TRACK_REASON_NONE, TOLIMAN_TRACK_REASON_ESTIMATE,
                                               "TOLIMAN_TRACK_REASON_..."};

inline int32_t public_verdict(track::Verdict verdict) noexcept {
    return verdict == track::Verdict::unreduced ? TOLIMAN_TRACK_VERDICT_UNREDUCED
           : verdict == track::Verdict::misfit  ? TOLIMAN_TRACK_VERDICT_MISFIT
                                                : kVerdicts.to_constant(verdict);
}

constexpr Choice<track::ColumnType> kColumnTypes = {TOLIMAN_TRACK_COLUMN_F64, TOLIMAN_TRACK_COLUMN_I64,
                                                    "TOLIMAN_TRACK_COLUMN_..."};

inline toliman_track_outcome public_outcome(const track::Outcome &outcome) noexcept {
    toliman_track_outcome out = {};
    out.verdict = public_verdict(outcome.verdict);
    out.reason = kReasons.to_constant(outcome.flaw.reason);
    TOLIMAN_COPY(out, outcome.flaw, row, col);
    out.pixel = outcome.flaw.value;
    if (outcome.verdict == track::Verdict::accepted || outcome.verdict == track::Verdict::unreduced ||
        outcome.verdict == track::Verdict::outlier || outcome.verdict == track::Verdict::misfit) {
        TOLIMAN_COPY(out, outcome, value, tai_ns, sigma);
    }
    set_goodness(outcome.goodness, out);
    out.bad_pixels = outcome.bad_pixels;
    return out;
}

inline toliman_track_record public_record(const track::Record &record, const track::Outcome &outcome) noexcept {
    toliman_track_record out = {};
    TOLIMAN_COPY(out, record, stream, frame_id, camera_ns, sigma, content, dropped);
    TOLIMAN_COPY(out, outcome, tai_ns, value);
    out.reason = kReasons.to_constant(record.reason);
    out.verdict = record.kind == track::Kind::merged      ? TOLIMAN_TRACK_VERDICT_MERGED
                  : record.kind == track::Kind::intervals ? TOLIMAN_TRACK_VERDICT_INTERVALS
                                                          : public_verdict(outcome.verdict);
    set_goodness(outcome.goodness, out);
    out.bad_pixels = outcome.bad_pixels;
    return out;
}

inline toliman_track_column public_column(const track::Column &column) noexcept {
    toliman_track_column out = {};
    out.type = kColumnTypes.to_constant(column.type);
    put_text(column.name, out.name);
    return out;
}

inline toliman_track_stream public_stream(const track::NamedStream &named) noexcept {
    toliman_track_stream out = {};
    static_assert(sizeof out.session > kLongestName && sizeof out.roi > kLongestName);
    out.stream = named.count.digest;
    out.first_id = named.count.first;
    out.last_id = named.count.last;
    out.frames = named.count.frames;
    const track::Wide missing = named.count.ids() - out.frames;
    out.missing = missing > INT64_MAX ? INT64_MAX : static_cast<int64_t>(missing);
    named.name.session.copy(out.session, kLongestName);
    named.name.roi.copy(out.roi, kLongestName);
    out.restarts = named.name.restarts;
    return out;
}

inline toliman_track_info public_info(const track::Tracker &tracker, uint32_t flags) noexcept {
    const track::Counts &counts = tracker.counts();
    toliman_track_info info = {};
    info.flags = flags;
    TOLIMAN_COPY(info, counts, received, accepted, unreduced, outlier, quarantined, repeated);
    for (size_t reason = 0; reason < std::size(counts.rejected); reason++) {
        const int32_t constant = kRejections.to_constant(static_cast<track::Reason>(reason));
        info.rejected_for[constant - TOLIMAN_TRACK_REASON_NONE] = counts.rejected[reason];
        info.rejected += counts.rejected[reason];
    }
    info.expected = tracker.expected();
    info.misfit = counts.misfit;
    info.missing =
        info.expected - counts.accepted - counts.unreduced - counts.outlier - counts.misfit - counts.quarantined;
    info.dropped = counts.dropped;
    info.sessions = static_cast<int64_t>(tracker.stream_count());
    info.records = static_cast<int64_t>(tracker.records());
    info.committed = static_cast<int64_t>(tracker.committed());
    info.capacity = tracker.plan().capacity;
    info.estimator_id = tracker.plan().terms.estimator;
    TOLIMAN_COPY(info, tracker.plan().terms, sigma, value_limit);
    info.chi_limit = tracker.chi_limit();
    info.chi_median = tracker.chi_median();
    const track::Reference &reference = tracker.plan().reference;
    info.plate_scale_arcsec = reference.scale_arcsec;
    for (uint32_t i = 0; i < track::kPartials; i++)
        info.elements |= tracker.plan().errors.sigmas[i] > 0 ? 1u << i : 0;
    info.system = reference.is_given() ? reference.system.c_str() : nullptr;
    return info;
}

} // namespace toliman::api
