// Superaccumulator: a fixed-point number that holds every sum of doubles exactly, so that the order does not matter.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/quad.hpp"

namespace toliman {

class ExactSum {
  public:
    // Digits of 32 bits in 64-bit places; the unit of place i is 2^(32 i - 1152). Spans 2^-1152 (below the smallest
    // subnormal, 2^-1074) to 2^1088.
    static constexpr int kPlaces = 70;
    using Places = std::array<int64_t, kPlaces>;

    // Adds a finite x exactly.
    void add(double x) noexcept;
    // Adds a b or a b^2 exactly, as an error-free expansion in doubles. No product may overflow or fall below 1e-290.
    void add_product(double a, double b) noexcept;
    void add_product_square(double a, double b) noexcept;
    // Adds factor a b, with a relative error of 2^-250.
    void add_product(const ExactSum &a, const ExactSum &b, double factor) noexcept;
    // Adds another sum exactly.
    void add(const ExactSum &other) noexcept;
    // Adds a number of 113 bits exactly, except for its part below 1e-290.
    void add_quad(Quad x) noexcept;
    // The sum, within 2 ulp of Quad.
    Quad value() const noexcept;
    // Canonical digits: all in [0, 2^32) but the last, which carries the sign. Equal sums have equal digits.
    Places canonical() const noexcept;
    void assign(const Places &digits) noexcept;

  private:
    static constexpr size_t kParts = 10; // digits from the first nonzero one
    void carry() noexcept;
    bool make_positive() noexcept;
    size_t parts(double *out) const noexcept; // the leading digits as doubles whose sum is the sum
    Places places_{};
    uint32_t pending_ = 0;
};

} // namespace toliman
