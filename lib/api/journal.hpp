// Journals that callers name.
#pragma once
#include <optional>
#include <utility>
#include <vector>

#include <toliman/version.h>

#include "backend/journal.hpp"

namespace toliman::api {

// Opens the journal at path; none if path is NULL. Another version of the library may compute other bits.
inline void open_journal(std::optional<Journal> &journal, const char *path, const char *work,
                         std::vector<Journal::Input> inputs) {
    if (path == nullptr)
        return;
    inputs.insert(inputs.begin(), {"another version of the library", TOLIMAN_VERSION_NUMBER});
    journal.emplace(path, work, std::move(inputs));
}

} // namespace toliman::api
