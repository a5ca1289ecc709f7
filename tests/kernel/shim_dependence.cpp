#include "information/dependence.hpp"

#include <cstring>

using namespace toliman;

namespace {

constexpr size_t kCapacity = 4096;

void append_line(int32_t /*level*/, const char *text, void *lines) {
    char *const start = static_cast<char *>(lines);
    text += std::strlen("scene: preprocess.project: ");
    std::strncat(std::strncat(start, text, kCapacity - std::strlen(start) - 2), "\n", 2);
}

} // namespace

// Given     names of one character each, images [length of names][pixels], variance [pixels]
// Returned  lines [4096]: the warnings, each with a newline
extern "C" void shim_dependence(const char *names, size_t pixels, const double *images, const double *variance,
                                char *lines) {
    FrameModel model;
    model.source = "scene";
    model.rows = 1;
    model.cols = pixels;
    model.variance.assign(variance, variance + pixels);
    for (; *names != '\0'; names++, images += pixels)
        model.projected.push_back({std::string(1, *names), Buffer<double>(images, images + pixels)});
    *lines = '\0';
    information::warn_of_dependence(model, {append_line, lines});
}
