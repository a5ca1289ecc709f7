// The known word that a mistyped one was probably meant to be.
#pragma once
#include <string>
#include <vector>

namespace toliman {

// The candidate with the least edit distance from `word`, the first of several; "" if none is near: at most 2 letters
// or a third of the word's letters may differ, and fewer than the candidate has.
std::string nearest_word(const std::string &word, const std::vector<std::string> &candidates);

} // namespace toliman
