// Time scales, formats and leap seconds as callers give them.
#pragma once
#include <toliman/ingest.h>

#include "api/choice.hpp"
#include "api/struct_array.hpp"
#include "ingest/time_scale.hpp"

namespace toliman::api {

constexpr Choice<ingest::Scale> kScales = {TOLIMAN_INGEST_SCALE_UTC, TOLIMAN_INGEST_SCALE_GPS,
                                           "TOLIMAN_INGEST_SCALE_..."};
constexpr Choice<ingest::TimeFormat> kFormats = {TOLIMAN_INGEST_FORMAT_ISO, TOLIMAN_INGEST_FORMAT_JD,
                                                 "TOLIMAN_INGEST_FORMAT_..."};

// The caller's table[count]; that of ERFA if it is empty. Status::argument, naming the row, for a wrong table.
inline ingest::LeapSeconds leap_seconds_of(const toliman_leap_second *table, size_t count, const char *name) {
    if (count == 0)
        return ingest::LeapSeconds(erfa::leap_seconds().rows);
    const StructArray<const toliman_leap_second> given(table, name);
    required_array(table, count, given.size(), name);
    ingest::LeapSecondRows rows;
    for (size_t i = 0; i < count; i++) {
        const toliman_leap_second row = given.get(i);
        if (!ingest::may_follow(rows, {row.mjd, row.tai_utc_s}))
            fail(Status::argument, "{%s[%zu]}: MJD %lld, %d s: %s", name, i, static_cast<long long>(row.mjd),
                 row.tai_utc_s, ingest::kLeapSecondRule);
        rows.push_back({row.mjd, row.tai_utc_s});
    }
    return ingest::LeapSeconds(std::move(rows));
}

} // namespace toliman::api
