// Method: morphological openings of both kinds in turn remove peninsulas and islands. A bridge between two areas stays
// small, whichever kind it gets; so that finally a square replaces it: of those that cover the cell, the one with the
// fewest small cells around it. Reference: Serra 1982, Image Analysis and Mathematical Morphology.
#include "mask/features.hpp"

#include <algorithm>

namespace toliman::mask {

namespace {

constexpr size_t kMostRounds = 20;

// 1 in cells that a square of side x side cells of this kind covers.
Buffer<uint8_t> opened(const Buffer<uint8_t> &cells, size_t n, size_t side, const Buffer<double> &open, uint8_t kind) {
    Buffer<uint8_t> found(cells.size());
    for (size_t y = 0; y + side <= n; y++)
        for (size_t x = 0; x + side <= n; x++) {
            bool whole = true;
            for (size_t i = 0; whole && i < side * side; i++) {
                const size_t at = (y + i / side) * n + x + i % side;
                whole = open[at] == 0 || cells[at] == kind;
            }
            for (size_t i = 0; whole && i < side * side; i++)
                found[(y + i / side) * n + x + i % side] = 1;
        }
    return found;
}

// Flips the open cells of this kind that no square covers; returns their number.
size_t open_kind(Buffer<uint8_t> &cells, size_t n, size_t side, const Buffer<double> &open, uint8_t kind) {
    const Buffer<uint8_t> large = opened(cells, n, side, open, kind);
    size_t changed = 0;
    for (size_t i = 0; i < cells.size(); i++)
        if (open[i] > 0 && cells[i] == kind && large[i] == 0) {
            cells[i] = 1 - kind;
            changed++;
        }
    return changed;
}

struct Cells {
    Buffer<uint8_t> &kind;
    const Buffer<double> &open;
    size_t n, side;

    bool is_small(size_t row, size_t col) const {
        const uint8_t own = kind[row * n + col];
        for (size_t y = row + 1 > side ? row + 1 - side : 0; y <= row && y + side <= n; y++)
            for (size_t x = col + 1 > side ? col + 1 - side : 0; x <= col && x + side <= n; x++) {
                bool whole = true;
                for (size_t i = 0; whole && i < side * side; i++) {
                    const size_t at = (y + i / side) * n + x + i % side;
                    whole = open[at] == 0 || kind[at] == own;
                }
                if (whole)
                    return false;
            }
        return true;
    }

    // Small cells that a change of the square at this cell can concern.
    size_t small_near(size_t row, size_t col) const {
        size_t count = 0;
        const size_t reach = 2 * side;
        for (size_t y = row > reach ? row - reach : 0; y <= std::min(row + reach, n - 1); y++)
            for (size_t x = col > reach ? col - reach : 0; x <= std::min(col + reach, n - 1); x++)
                count += open[y * n + x] > 0 && is_small(y, x) ? 1 : 0;
        return count;
    }

    // Gives the kind of the cell to the square with the fewest small cells around it; returns whether that is an
    // improvement.
    bool widen(size_t row, size_t col) {
        const uint8_t own = kind[row * n + col];
        const size_t present = small_near(row, col);
        size_t fewest = present;
        const Buffer<uint8_t> before = kind;
        Buffer<uint8_t> best = kind;
        for (size_t y = row + 1 > side ? row + 1 - side : 0; y <= row && y + side <= n; y++)
            for (size_t x = col + 1 > side ? col + 1 - side : 0; x <= col && x + side <= n; x++) {
                kind = before;
                for (size_t i = 0; i < side * side; i++) {
                    const size_t at = (y + i / side) * n + x + i % side;
                    kind[at] = open[at] > 0 ? own : kind[at];
                }
                const size_t count = small_near(row, col);
                if (count < fewest) {
                    fewest = count;
                    best = kind;
                }
            }
        kind = best;
        return fewest < present;
    }
};

} // namespace

// Each opening may create small features of the other kind, so that both are repeated until neither changes a cell.
// After kMostRounds only bridges are left.
Buffer<uint8_t> without_small_features(Buffer<uint8_t> cells, size_t samples, size_t side, const Buffer<double> &open) {
    for (size_t round = 0; round < kMostRounds; round++)
        if (open_kind(cells, samples, side, open, 1) + open_kind(cells, samples, side, open, 0) == 0)
            return cells;
    Cells all = {cells, open, samples, side};
    bool better = true;
    for (size_t round = 0; better && round < kMostRounds; round++) {
        better = false;
        for (size_t i = 0; i < cells.size(); i++)
            if (open[i] > 0 && all.is_small(i / samples, i % samples))
                better = all.widen(i / samples, i % samples) || better;
    }
    return cells;
}

double small_fraction(const Buffer<uint8_t> &cells, size_t samples, size_t side, const Buffer<double> &open) {
    const auto open_cells =
        static_cast<double>(std::count_if(open.begin(), open.end(), [](double amplitude) { return amplitude > 0; }));
    Buffer<uint8_t> ones = cells, zeros = cells;
    return static_cast<double>(open_kind(ones, samples, side, open, 1) + open_kind(zeros, samples, side, open, 0)) /
           open_cells;
}

} // namespace toliman::mask
