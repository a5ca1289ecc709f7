#include "track/terms.hpp"

#include "base/bytes.hpp"
#include "base/error.hpp"

namespace toliman::track {

namespace {

constexpr double kLeast = 1e-90, kMost = 1e90; // so that a periodogram can carry them

} // namespace

void Terms::check() const {
    geometry.check();
    if (!(sigma >= kLeast && sigma <= kMost))
        fail(Status::argument, "sigma = %g: must be in [%g, %g]", sigma, kLeast, kMost);
    if (!(value_limit >= kLeast && value_limit <= kMost))
        fail(Status::argument, "value_limit = %g: must be in [%g, %g]", value_limit, kLeast, kMost);
}

TermsBytes to_bytes(const Terms &terms) noexcept {
    const Geometry &g = terms.geometry;
    TermsBytes bytes;
    uint8_t *at = bytes.data();
    for (const size_t part : {g.rows, g.cols, g.crop_row, g.crop_col, g.out_rows, g.out_cols, g.bin})
        at = put_number(at, part, 8);
    at = put_number(at, g.bit_depth, 8);
    at = put_number(at, g.hole, 8);
    at = put_number(at, with_bits<uint64_t>(terms.sigma), 8);
    at = put_number(at, with_bits<uint64_t>(terms.value_limit), 8);
    put_number(at, terms.estimator, 8);
    return bytes;
}

Terms terms_of(const uint8_t *bytes) noexcept {
    Terms terms;
    Geometry &g = terms.geometry;
    for (size_t *part : {&g.rows, &g.cols, &g.crop_row, &g.crop_col, &g.out_rows, &g.out_cols, &g.bin})
        *part = take_number(bytes, 8);
    g.bit_depth = static_cast<uint32_t>(take_number(bytes, 8));
    g.hole = take_number(bytes, 8);
    terms.sigma = with_bits<double>(take_number(bytes, 8));
    terms.value_limit = with_bits<double>(take_number(bytes, 8));
    terms.estimator = take_number(bytes, 8);
    return terms;
}

} // namespace toliman::track
