// Journals that callers name.
#pragma once
#include <optional>
#include <utility>
#include <vector>

#include <toliman/version.h>

#include "backend/journal.hpp"

namespace toliman::api {

// Opens the journal at path; none if path is NULL. Another version of the library may compute other bits. inputs():
// what the work depends on.
template <class Inputs>
void open_journal(std::optional<Journal> &journal, const char *path, const char *work, const Inputs &inputs) {
    if (path == nullptr)
        return;
    std::vector<Journal::Input> all = inputs();
    all.insert(all.begin(), {"another version of the library", TOLIMAN_VERSION_NUMBER});
    journal.emplace(path, work, std::move(all));
}

} // namespace toliman::api
