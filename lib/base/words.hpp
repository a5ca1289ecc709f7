// Lists of names in a text of the caller, separated by spaces or commas. Every list of the interface is read here.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace toliman {

// Empty names are ignored, so that spaces may follow commas.
inline std::vector<std::string> words_of(std::string_view text) {
    constexpr char kBetween[] = " ,";
    std::vector<std::string> words;
    for (size_t at = text.find_first_not_of(kBetween); at != text.npos;) {
        const size_t end = text.find_first_of(kBetween, at);
        words.emplace_back(text.substr(at, end - at)); // to the end of the text if there is no separator
        at = text.find_first_not_of(kBetween, end);
    }
    return words;
}

} // namespace toliman
