#include "ingest/instrument_column.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "ingest/column_names.hpp"
#include "ingest/fields.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kMostInstruments = 256, kMostTexts = 16;
constexpr int64_t kFewestRows = 3; // per text

bool is_flag(const std::string &text) {
    static const std::string flags[] = {"t", "f", "true", "false", "y", "n", "yes", "no", "ok", "good", "bad"};
    return std::find(std::begin(flags), std::end(flags), lower(text)) != std::end(flags);
}

} // namespace

int64_t Instruments::index_of(const std::string &name) {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found != names_.end())
        return found - names_.begin();
    if (names_.size() == kMostInstruments)
        fail(Status::format, "{instrument} = \"%.60s\": must be one of at most %zu", name.c_str(), kMostInstruments);
    names_.push_back(name);
    return static_cast<int64_t>(names_.size()) - 1;
}

void LikelyInstrument::add(const std::string &name, const std::string &text) {
    if (next_ >= columns_.size() || columns_[next_].name != name) {
        const auto found =
            std::find_if(columns_.begin(), columns_.end(), [&](const Column &column) { return column.name == name; });
        next_ = static_cast<size_t>(found - columns_.begin());
        if (found == columns_.end() && columns_.size() == kMostColumns)
            return;
        if (found == columns_.end())
            columns_.push_back({name, is_instrument(name), true, 0, {}});
    }
    Column &column = columns_[next_];
    next_ = (next_ + 1) % columns_.size();
    double number = 0;
    if (!column.possible || is_missing(text))
        return;
    column.rows++;
    column.texts.insert(text);
    column.possible =
        column.texts.size() <= kMostTexts && (column.is_named || !(number_of(text, number) || is_flag(text)));
}

std::string LikelyInstrument::name() const {
    const Column *likely = nullptr;
    for (const Column &column : columns_) {
        const bool few = column.is_named || column.rows >= kFewestRows * static_cast<int64_t>(column.texts.size());
        if (column.possible && column.texts.size() >= 2 && few && (likely == nullptr || column.is_named))
            likely = &column;
    }
    return likely != nullptr ? in_ascii(likely->name) : "";
}

} // namespace toliman::ingest
