#include "track/terms.hpp"

#include <cmath>

#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/text.hpp"

namespace toliman::track {

namespace {

constexpr double kMin = 1e-90, kMax = 1e90; // limits of a periodogram, with a margin

} // namespace

void Terms::check() const {
    geometry.check();
    if (!(sigma >= kMin && sigma <= kMax))
        fail(Status::argument, "{sigma} = %g: must be in [%g, %g]", sigma, kMin, kMax);
    if (!(value_limit >= kMin && value_limit <= kMax))
        fail(Status::argument, "{value_limit} = %g: must be in [%g, %g]", value_limit, kMin, kMax);
}

bool Terms::allow(const Record &record, bool reduced) const noexcept {
    if (record.kind == Kind::merged) {
        const MergeMark merged = merge_mark_of(record);
        return merged.records >= 0 && merged.repeats >= 0 && merged.repeats <= kMaxRepeats;
    }
    const bool is_limited = record.kind == Kind::accepted && !reduced;
    return allows_sigma(record.sigma) && !(is_limited && std::fabs(record.value) > value_limit);
}

std::string difference(const Terms &there, const Terms &here) {
    char text[160];
    const Geometry &a = there.geometry, &b = here.geometry;
    const auto sides = [&](const char *name, size_t rows, size_t cols, size_t own_rows, size_t own_cols) {
        print_text(text, sizeof text, "%s %zux%zu, this tracker has %zux%zu", name, rows, cols, own_rows, own_cols);
        return std::string(text);
    };
    const auto number = [&](const char *name, double value, double own_value) {
        print_text(text, sizeof text, "%s %.17g, this tracker has %.17g", name, value, own_value);
        return std::string(text);
    };
    if (a.rows != b.rows || a.cols != b.cols)
        return sides("frames of", a.rows, a.cols, b.rows, b.cols);
    if (a.crop_row != b.crop_row || a.crop_col != b.crop_col)
        return sides("crop from", a.crop_row, a.crop_col, b.crop_row, b.crop_col);
    if (a.out_rows != b.out_rows || a.out_cols != b.out_cols)
        return sides("images of", a.out_rows, a.out_cols, b.out_rows, b.out_cols);
    if (a.bin != b.bin)
        return number("bin", static_cast<double>(a.bin), static_cast<double>(b.bin));
    if (a.bit_depth != b.bit_depth)
        return number("bit depth", a.bit_depth, b.bit_depth);
    if (a.zero_run != b.zero_run)
        return number("zero run bytes", static_cast<double>(a.zero_run), static_cast<double>(b.zero_run));
    if (there.estimator != here.estimator) { // before what follows from it
        print_text(
            text, sizeof text,
            "estimator %016llx, this tracker has %016llx: the estimator, its scene or a file of the scene has changed",
            static_cast<unsigned long long>(there.estimator), static_cast<unsigned long long>(here.estimator));
        return text;
    }
    if (there.sigma != here.sigma)
        return number("sigma", there.sigma, here.sigma);
    return number("value limit", there.value_limit, here.value_limit);
}

TermsBytes to_bytes(const Terms &terms) noexcept {
    const Geometry &g = terms.geometry;
    TermsBytes bytes;
    uint8_t *at = bytes.data();
    for (const size_t part : {g.rows, g.cols, g.crop_row, g.crop_col, g.out_rows, g.out_cols, g.bin})
        at = put_number(at, part, 8);
    at = put_number(at, g.bit_depth, 8);
    at = put_number(at, g.zero_run, 8);
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
    g.zero_run = take_number(bytes, 8);
    terms.sigma = with_bits<double>(take_number(bytes, 8));
    terms.value_limit = with_bits<double>(take_number(bytes, 8));
    terms.estimator = take_number(bytes, 8);
    return terms;
}

} // namespace toliman::track
