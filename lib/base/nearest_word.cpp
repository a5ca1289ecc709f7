// Method: Levenshtein distance (insertions, deletions and replacements of letters) by dynamic programming over one row
// (Wagner and Fischer 1974, J. ACM 21, 168).
#include "base/nearest_word.hpp"

#include <algorithm>

namespace toliman {

namespace {

constexpr size_t kLongest = 64; // no known word is longer; avoids quadratic time on long input

size_t edit_distance(const std::string &a, const std::string &b) {
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); j++)
        row[j] = j;
    for (size_t i = 1; i <= a.size(); i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); j++) {
            const size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row[b.size()];
}

} // namespace

std::string nearest_word(const std::string &word, const std::vector<std::string> &candidates) {
    std::string best;
    if (word.size() > kLongest)
        return best;
    size_t least = std::max<size_t>(2, word.size() / 3) + 1;
    for (const std::string &candidate : candidates) {
        const size_t distance = edit_distance(word, candidate);
        if (distance < std::min(least, candidate.size())) {
            least = distance;
            best = candidate;
        }
    }
    return best;
}

} // namespace toliman
