// Registration of a frame on the model, and the pixels that are left out of a sum.
#pragma once
#include <array>

#include "coadd/table.hpp"

namespace toliman::coadd {

constexpr size_t kMostLeftOut = 256; // pixels of a frame

enum class Verdict { added, next, lost, faint, not_found, outside, misfit };

struct Registered {
    Verdict verdict = Verdict::added;
    double flux = 0, x = 0, y = 0;      // relative flux; px from the predicted place
    double xx = 0, xy = 0, yy = 0;      // covariance of x and y
    double chi_square = 0;              // per degree of freedom, without the pixels that are left out
    size_t left_out = 0, saturated = 0; // pixels; those that are saturated among them
    std::array<uint32_t, kMostLeftOut> pixels;
    std::array<float, kMostLeftOut> expected; // counts of these
};

// Const calls may run on several threads, each with its own work.
class Registration {
  public:
    // Starts no more than the fit needs; frames of fit.rows() x fit.cols().
    Registration(const fit::Fit &fit, const fit::Prediction &prediction, int range, double most_chi_square,
                 unsigned workers, const Progress &progress);

    // Depends on the counts only. A frame without a verdict other than `added` has all numbers.
    void frame(const kernels::CoaddFrame &frame, Registered &out) const noexcept;

    double photons() const noexcept { return photons_; } // of a frame at the predicted place
    size_t bytes() const noexcept { return table_.bytes() + near_.table.bytes() + far_.table.bytes(); }

  private:
    struct Estimate {
        double flux, x, y;
    };
    struct Solution {
        Estimate step; // flux; x and y times flux
        double covariance[3][3], chi_square;
        bool found;
    };
    // Rows of a frame: all of them, or every `step`-th.
    struct Rows {
        size_t start = 0, step = 1;
    };
    Solution solve(const kernels::CoaddFrame &frame, const Table &table, const Cell &cell, double flux, Rows rows,
                   const Registered *left_out) const noexcept;
    // Blurred images at whole pixels, of which a step is zero[] + gain times the displacement.
    struct Coarse {
        Table table;
        double zero[2], inverse[2][2]; // inverse of the gain
    };
    Coarse make_coarse(const fit::Fit &fit, const fit::Prediction &prediction, int range, double blur,
                       unsigned workers) const;
    bool start(const kernels::CoaddFrame &frame, Rows rows, const Coarse &coarse, Estimate &at) const noexcept;
    bool approach(const kernels::CoaddFrame &frame, Rows rows, Estimate &at) const noexcept;
    void attempt(const kernels::CoaddFrame &frame, Rows rows, bool is_far, Registered &out) const noexcept;
    bool finish(const kernels::CoaddFrame &frame, Estimate &at, Registered &out) const noexcept;
    kernels::CoaddPixels pixels(const fit::Model &model, double most_photons);
    void expect(const fit::Fit &fit, const fit::Prediction &prediction);

    Table table_;
    size_t rows_, cols_;
    double most_chi_square_;
    std::vector<uint32_t> bad_; // pixels of the scene that are not used
    size_t used_ = 0;           // the others
    Buffer<float> gain_, offset_, spread_, added_;
    kernels::CoaddPixels pixels_; // made with those before it
    size_t dark_rows_ = 0;        // rows whose counts may all be 0
    double photons_ = 0;
    Coarse near_, far_; // made with the members before them
};

} // namespace toliman::coadd
