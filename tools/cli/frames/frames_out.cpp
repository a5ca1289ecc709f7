#include "frames/frames_out.hpp"

#include "common/npy.hpp"
#include "common/output.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

class NpyOutput : public FrameOutput {
  public:
    NpyOutput(const std::string &path, const std::vector<size_t> &axes)
        : out_(path), pixels_(axes.back() * axes[axes.size() - 2]) {
        write_npy_header(out_, axes);
        out_.need_space(axes, sizeof(double));
    }
    void write(const double *images, size_t count) override { out_.write(images, count * pixels_ * sizeof *images); }
    void commit() override { out_.commit(); }

  private:
    OutputFile out_;
    size_t pixels_;
};

} // namespace

std::unique_ptr<FrameOutput> image_output(const std::string &path, const std::vector<size_t> &axes,
                                          const Scene *scene) {
    if (ends_with(path, ".fits"))
        return fits_output(path, axes, scene);
    return std::make_unique<NpyOutput>(path, axes);
}

} // namespace cli
