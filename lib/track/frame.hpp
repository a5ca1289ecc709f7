// A frame from the downlink: validation, CRC32 of its content, cropped and binned pixels for the estimator.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "frame/detector_window.hpp"
#include "frame/pixel.hpp"
#include "frame/spread.hpp"
#include "track/record.hpp"

namespace toliman::track {

struct Frame {
    const char *session, *roi;
    int64_t frame_id, camera_ns;
    double sigma; // of its value; 0: the terms' sigma
    const void *pixels;
    size_t rows, cols, stride; // in pixels
    Pixel pixel;
    int64_t dropped, restarts;
    double exposure_s;              // s; 0: unknown
    const double *intervals;        // on target: pairs (start, end) in s from the start of the exposure, increasing
    size_t interval_count;          // number of pairs; 0: unknown
    int64_t window_row, window_col; // of the first pixel on the detector
    Spread spread = {};             // of a sum of frames
    std::optional<DetectorWindow> image_window = {}; // of the estimator's image, unless its pixels are binned
    bool is_reduced = false;                         // the estimate is of the separation, not of a difference
};

// Returns the mean time of the intervals minus the middle of the exposure; 0 without intervals.
double mean_shift_s(const Frame &frame) noexcept;

// Required geometry of frames, rows x cols pixels, and of the estimator's image: from (crop_row, crop_col), blocks of
// bin x bin pixels are summed to out_rows x out_cols.
struct Geometry {
    size_t rows, cols, crop_row, crop_col, out_rows, out_cols, bin;
    uint32_t bit_depth; // 0: any value
    size_t zero_run;    // bytes of consecutive zero pixels that reject a frame; 0: no limit
    void check() const; // Status::argument
};

// Why and where a frame is invalid.
struct Flaw {
    Reason reason = Reason::none;
    size_t row = 0, col = 0; // of the pixel; of reason shape: the frame's rows and columns
    double value = 0;
};

// CRC32 of everything that a duplicate has in common: all but the key and the stride.
uint32_t content_of(const Frame &frame) noexcept;

// Returns the first flaw, or none after writing the image to out [out_rows * out_cols].
Flaw check_and_bin(const Frame &frame, const Geometry &geometry, double *out) noexcept;

} // namespace toliman::track
