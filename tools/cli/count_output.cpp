// Frames as headerless little-endian counts.
#include <cmath>

#include "failure.hpp"
#include "frames_out.hpp"
#include "output.hpp"

namespace cli {

namespace {

class CountOutput : public FrameOutput {
  public:
    CountOutput(const std::string &path, const CountFormat &format, const Simulated &frames)
        : path_(path), out_(path), format_(format), rows_(frames.rows()), cols_(frames.cols()),
          next_(frames.range.first), largest_(std::ldexp(1.0, format.bit_depth) - 1) {}

    void write(const double *images, size_t count) override {
        for (size_t k = 0; k < count; k++, next_++) {
            if (format_.wide)
                write_frame<uint32_t>(images + k * rows_ * cols_);
            else
                write_frame<uint16_t>(images + k * rows_ * cols_);
        }
    }

    void commit() override { out_.commit(); }

  private:
    // Read noise may take a dark pixel below zero: it is stored as 0.
    template <class T> void write_frame(const double *image) {
        std::vector<T> counts(rows_ * cols_);
        for (size_t i = 0; i < counts.size(); i++) {
            const double rounded = std::fmax(0.0, std::nearbyint(image[i]));
            if (rounded > largest_)
                overflow(i, rounded);
            counts[i] = static_cast<T>(rounded);
        }
        out_.write(counts.data(), counts.size() * sizeof counts[0]);
    }

    [[noreturn]] void overflow(size_t pixel, double counts) const {
        char text[160];
        std::snprintf(text, sizeof text, "frame %lld, row %zu, column %zu: %.0f counts, %d bits hold 0 to %.0f",
                      static_cast<long long>(next_), pixel / cols_, pixel % cols_, counts, format_.bit_depth, largest_);
        throw Failure(kExitUsage, path_ + ": bit depth overflow: " + text);
    }

    std::string path_;
    OutputFile out_;
    CountFormat format_;
    size_t rows_, cols_;
    int64_t next_; // number of the next frame
    double largest_;
};

} // namespace

std::unique_ptr<FrameOutput> count_output(const std::string &path, const CountFormat &format, const Simulated &frames) {
    return std::make_unique<CountOutput>(path, format, frames);
}

} // namespace cli
