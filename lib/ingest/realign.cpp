// Method: the square roots of counts, whose noise is the same in all pixels, are correlated with those of a good frame
// of the same scene, at every byte of the range: first in its 256 brightest pixels, then the best places in all pixels.
// The correlation coefficient of two frames of a scene is near 1 wherever photons dominate; a frame that is read one
// pixel off has another image, and one that is read a byte off has no image at all. The fit decides in the end.
#include "ingest/realign.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace toliman::ingest {

namespace {

constexpr size_t kBrightest = 256, kCandidates = 8;
constexpr double kLeastLikeness = 0.5; // correlation coefficient

double root_at(const uint8_t *bytes, size_t pixel_bytes) noexcept {
    uint32_t count = 0;
    std::memcpy(&count, bytes, pixel_bytes);
    return std::sqrt(static_cast<double>(count));
}

// Square roots of the pixels that begin at bytes[0], bytes[pixel_bytes], ...
std::vector<double> roots_of(const uint8_t *bytes, size_t count, size_t pixel_bytes) {
    std::vector<double> roots(count);
    for (size_t i = 0; i < count; i++)
        roots[i] = root_at(bytes + i * pixel_bytes, pixel_bytes);
    return roots;
}

double likeness(const double *a, const double *b, size_t count) noexcept {
    double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
    for (size_t i = 0; i < count; i++) {
        mean_a += a[i] / static_cast<double>(count);
        mean_b += b[i] / static_cast<double>(count);
    }
    for (size_t i = 0; i < count; i++) {
        aa += (a[i] - mean_a) * (a[i] - mean_a);
        bb += (b[i] - mean_b) * (b[i] - mean_b);
        ab += (a[i] - mean_a) * (b[i] - mean_b);
    }
    return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

struct Candidate {
    double score;
    int64_t offset;
};

// Sums of the brightest pixels over the root of those of all, at each place of a byte phase.
void add_candidates(const std::vector<double> &roots, const std::vector<size_t> &brightest, size_t pixels,
                    int64_t first, int64_t step, std::vector<Candidate> &best) {
    double energy = 0;
    for (size_t i = 0; i < pixels; i++)
        energy += roots[i] * roots[i];
    for (size_t place = 0; place + pixels <= roots.size(); place++) {
        double sum = 0;
        for (const size_t pixel : brightest)
            sum += roots[place + pixel];
        best.push_back({energy > 0 ? sum / std::sqrt(energy) : 0, first + static_cast<int64_t>(place) * step});
        std::push_heap(best.begin(), best.end(),
                       [](const Candidate &a, const Candidate &b) { return a.score > b.score; });
        if (best.size() > kCandidates) {
            std::pop_heap(best.begin(), best.end(),
                          [](const Candidate &a, const Candidate &b) { return a.score > b.score; });
            best.pop_back();
        }
        if (place + pixels < roots.size())
            energy =
                std::max(0.0, energy + roots[place + pixels] * roots[place + pixels] - roots[place] * roots[place]);
    }
}

} // namespace

std::optional<int64_t> find_frame(const file::Reader &file, const Search &search, const void *reference) {
    const auto frame_bytes = static_cast<int64_t>(search.pixels * search.pixel_bytes);
    const int64_t size = static_cast<int64_t>(file.stamp().size), first = std::max<int64_t>(search.first, 0),
                  last = std::min(search.last, size - frame_bytes);
    if (first > last)
        return std::nullopt;
    std::vector<uint8_t> bytes(static_cast<size_t>(last - first + frame_bytes));
    file.read_exactly(static_cast<uint64_t>(first), bytes.data(), bytes.size());
    const std::vector<double> wanted =
        roots_of(static_cast<const uint8_t *>(reference), search.pixels, search.pixel_bytes);
    std::vector<size_t> brightest(search.pixels);
    for (size_t i = 0; i < brightest.size(); i++)
        brightest[i] = i;
    const size_t few = std::min(kBrightest, brightest.size());
    std::partial_sort(brightest.begin(), brightest.begin() + static_cast<ptrdiff_t>(few), brightest.end(),
                      [&](size_t a, size_t b) { return wanted[a] > wanted[b]; });
    brightest.resize(few);
    std::vector<Candidate> candidates;
    for (size_t phase = 0; phase < search.pixel_bytes && phase <= static_cast<size_t>(last - first); phase++) {
        const std::vector<double> roots =
            roots_of(bytes.data() + phase, (bytes.size() - phase) / search.pixel_bytes, search.pixel_bytes);
        add_candidates(roots, brightest, search.pixels, first + static_cast<int64_t>(phase),
                       static_cast<int64_t>(search.pixel_bytes), candidates);
    }
    std::optional<int64_t> found;
    double best = kLeastLikeness;
    for (const Candidate &candidate : candidates) {
        const std::vector<double> there =
            roots_of(bytes.data() + (candidate.offset - first), search.pixels, search.pixel_bytes);
        const double likeness_there = likeness(wanted.data(), there.data(), search.pixels);
        if (likeness_there > best) {
            best = likeness_there;
            found = candidate.offset;
        }
    }
    return found;
}

} // namespace toliman::ingest
