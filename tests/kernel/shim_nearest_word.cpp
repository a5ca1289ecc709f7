// C interface to the nearest word, for the test.
#include <cstring>

#include "base/nearest_word.hpp"

// Stores the nearest of `count` candidates.
extern "C" void shim_nearest_word(const char *word, const char *const *candidates, size_t count, char *nearest) {
    std::strcpy(nearest, toliman::nearest_word(word, {candidates, candidates + count}).c_str());
}
