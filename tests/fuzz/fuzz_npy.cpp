// .npy files that the program reads: frames, and a table of samples.
#include <cmath>
// promise: parsers-are-safe

#include "common/failure.hpp"
#include "frames/frames_in.hpp"
#include "fuzz.hpp"
#include "memory_file.hpp"
#include "series/series.hpp"

using namespace fuzz;

namespace {

template <class Work> void tried(Work work) {
    try {
        work();
    } catch (const cli::Failure &failure) {
        require(failure.code() == cli::kExitInput, failure.what());
    }
}

void read_frames(const std::string &path, size_t size) {
    const auto frames = cli::open_frames(path);
    const size_t pixels = frames->rows() * frames->cols();
    fuzz::accepted++;
    require(pixels > 0 && pixels * frames->count() <= size, "more pixels than the file has bytes");
    std::vector<double> image(pixels);
    for (size_t k = 0; k < 3 && frames->more(); k++) {
        frames->read_finite(image.data());
        for (const double pixel : image)
            require(std::isfinite(pixel), "a pixel that is not finite");
        if (frames->more())
            frames->skip();
    }
}

void read_table(const std::string &path) {
    cli::Progress quiet(cli::Progress::Style::none);
    const toliman::measurements series = cli::read_series(path, {}, quiet);
    const std::vector<double> t = cli::values_of(series.get(), "t"), y = cli::values_of(series.get(), "y");
    require(!t.empty() && t.size() == y.size(), "an empty table");
    for (const double sigma : cli::values_of(series.get(), "sigma"))
        require(sigma > 0, "an impossible sigma");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    return {npy("<f8", "3, 2", 48), npy("<f8", "2, 3", 48), npy("<u2", "3, 2, 4", 48), npy("<f4", "2, 6", 48),
            npy("|u1", "4, 3, 4", 48)};
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static MemoryFile file("x.npy");
    file.set(data, size);
    tried([&] { read_frames(file.path(), size); });
    if (size > 6 && std::memcmp(data, "\x93NUMPY", 6) == 0)
        tried([&] { read_table(file.path()); });
    return 0;
}
