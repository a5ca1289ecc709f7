#include "track/names.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "base/name.hpp"
#include "track/identity.hpp"

namespace toliman::track {

namespace {

constexpr size_t kShortestLine = 1 + 2 * (1 + 1);                         // without its newline
constexpr size_t kLongestLine = 16 + 2 * (1 + kLongestName) + 1 + 20 + 1; // with its newline

} // namespace

void Names::visit(const Each &each) const {
    const int64_t size = store_.size(kName);
    if (size <= 0)
        return;
    std::string text(static_cast<size_t>(size), '\0');
    text.resize(store_.read(kName, 0, text.data(), text.size()));
    for (size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
        if (end - at < kShortestLine)
            continue;
        unsigned long long digest = 0;
        long long restarts = 0;
        char session[kLongestName + 1], roi[kLongestName + 1];
        const std::string line = text.substr(at, std::min(end - at, kLongestLine));
        static_assert(kLongestName == 64, "widths below");
        if (std::sscanf(line.c_str(), "%16llx %64s %64s %lld", &digest, session, roi, &restarts) >= 3 &&
            is_name(session) && is_name(roi) && digest == stream_digest(session, roi, restarts))
            each(digest, {session, roi, restarts});
    }
}

void Names::begin() {
    store_.write(kName, static_cast<uint64_t>(std::max<int64_t>(0, store_.size(kName))), "", 0);
}

// If the last line is torn, begins with a newline.
void Names::add(uint64_t digest, std::string_view session, std::string_view roi, int64_t restarts) {
    char line[kLongestLine + 2];
    const int64_t size = store_.size(kName);
    char last = '\n';
    if (size > 0)
        read_all(store_, kName, static_cast<uint64_t>(size) - 1, &last, 1);
    int length = std::snprintf(line, sizeof line, "%s%016llx %.*s %.*s", last == '\n' ? "" : "\n",
                               static_cast<unsigned long long>(digest), static_cast<int>(session.size()),
                               session.data(), static_cast<int>(roi.size()), roi.data());
    char *const end = line + length;
    length += restarts == 0 ? std::snprintf(end, sizeof line - static_cast<size_t>(length), "\n")
                            : std::snprintf(end, sizeof line - static_cast<size_t>(length), " %lld\n",
                                            static_cast<long long>(restarts));
    added_ = true;
    store_.write(kName, static_cast<uint64_t>(size), line, static_cast<size_t>(length));
}

void Names::sync() {
    if (!added_)
        return;
    store_.sync(kName);
    added_ = false;
}

} // namespace toliman::track
