// Expat: elements of an XML file.
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace toliman::xml {

struct Element {
    std::string name; // without prefix of its namespace
    std::vector<std::pair<std::string, std::string>> attributes;
    std::string text; // up to the element within it, or its end
    int line = 0;     // of its beginning
    // Empty if there is no such attribute.
    std::string attribute(std::string_view wanted) const;
};

// Receives each element when it begins, without its text, and when it ends. May throw.
struct Sink {
    std::function<void(const Element &)> begin, end;
};

// Status::format, with path and line, if the text is not well-formed, or has a document type, which can define entities
// of any size, or more than 32 levels.
void parse(const char *path, std::string_view text, const Sink &sink);

} // namespace toliman::xml
