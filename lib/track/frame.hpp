// A frame as it comes off the downlink: whether it can be trusted, its identity, and its pixels as an estimator takes
// them.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/pixel.hpp"
#include "track/record.hpp"

namespace toliman::track {

struct Frame {
    const char *session, *roi;
    int64_t frame_id, camera_ns;
    double sigma; // of its value; 0: as the terms have it
    const void *pixels;
    size_t rows, cols, stride; // in pixels
    Pixel pixel;
    uint16_t dropped;
    double exposure_s;              // 0: not known
    const double *intervals;        // on the target: pairs of s from the start of the exposure, rising
    size_t interval_count;          // pairs; 0: not known
    int64_t window_row, window_col; // of the first pixel on the detector
};

// Mean time of the intervals minus the middle of the exposure; 0 without intervals.
double mean_shift_s(const Frame &frame) noexcept;

// What frames must be like, and what becomes of them: rows x cols pixels; of these bin x bin pixels each are added up,
// from the pixel (crop_row, crop_col) on, to out_rows x out_cols.
struct Geometry {
    size_t rows, cols, crop_row, crop_col, out_rows, out_cols, bin;
    uint32_t bit_depth; // 0: any value
    size_t zero_run;    // bytes of consecutive zero pixels that reject a frame; 0: no limit
    void check() const; // Status::argument
};

// Where a frame fails.
struct Flaw {
    Reason reason = Reason::none;
    size_t row = 0, col = 0; // of shape: its rows and columns
    double value = 0;
};

// CRC32 of what must be the same when a frame comes again: all but its key and the stride.
uint32_t content_of(const Frame &frame) noexcept;

// The first flaw, or none and out [out_rows * out_cols].
Flaw take(const Frame &frame, const Geometry &geometry, double *out) noexcept;

} // namespace toliman::track
