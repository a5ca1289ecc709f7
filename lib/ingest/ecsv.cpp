// Method: of the YAML only what astropy writes is read: the list below "datatype:", one entry "- {name: a, unit: m / s,
// ...}" or a block of lines for each column, and "delimiter". Reference: Astropy Proposal for Enhancement 6.
#include "ingest/ecsv.hpp"

#include <algorithm>

#include "ingest/fields.hpp"

namespace toliman::ingest {

namespace {

// The scalar of a key; "" if there is none.
std::string scalar_of(const std::string &text, const std::string &key) {
    for (size_t at = text.find(key + ":"); at != text.npos; at = text.find(key + ":", at + 1)) {
        if (at > 0 && std::string("{ ,\n-").find(text[at - 1]) == std::string::npos)
            continue;
        const size_t start = text.find_first_not_of(' ', at + key.size() + 1);
        if (start == text.npos || text[start] == '!') // a tagged value contains the key again
            continue;
        const bool quoted = text[start] == '\'' || text[start] == '"';
        const size_t first = start + (quoted ? 1 : 0);
        const size_t end = quoted ? text.find(text[start], first) : text.find_first_of(",}\n", first);
        const std::string value = text.substr(first, std::min(end, text.size()) - first);
        return quoted ? value : trimmed(value);
    }
    return "";
}

} // namespace

EcsvHeader parse_ecsv(const std::string &text) {
    EcsvHeader header;
    if (scalar_of("\n" + text, "delimiter") == ",")
        header.delimiter = ',';
    const size_t list = text.find("datatype:");
    for (size_t at = list != text.npos ? text.find("\n- ", list) : list; at != text.npos;) {
        const size_t next = text.find("\n- ", at + 1);
        const std::string entry = text.substr(at + 1, next - at - 1);
        header.units.emplace_back(scalar_of(entry, "name"), scalar_of(entry, "unit"));
        at = next;
    }
    return header;
}

} // namespace toliman::ingest
