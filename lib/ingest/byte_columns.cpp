// Method: a machine-readable table begins with its title. "Byte-by-byte Description" announces the heading "Bytes
// Format Units Label Explanations", below which each line describes a column until a line of dashes. Notes and a
// further line of dashes may follow, then the rows. Reference: Standards for Astronomical Catalogues, CDS 2.0; AAS
// machine-readable tables.
#include "ingest/byte_columns.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "base/error.hpp"
#include "ingest/fields.hpp"

namespace toliman::ingest {

namespace {

bool begins_with(std::string_view text, std::string_view start) noexcept {
    return text.substr(0, start.size()) == start;
}

bool is_description(std::string_view line) {
    return lower(line).find("byte-by-byte description") != std::string::npos;
}

size_t take_number(std::string_view &text) noexcept {
    text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
    size_t number = 0;
    const char *const end = std::from_chars(text.data(), text.data() + text.size(), number).ptr;
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    return number;
}

// Places after the point of F9.3 and E12.4, 0 of I4.
int decimals_of(const std::string &format) noexcept {
    if (format[0] == 'A')
        return kTextColumn;
    const size_t point = format.find('.');
    int places = 0;
    if (point != std::string::npos)
        std::from_chars(format.data() + point + 1, format.data() + format.size(), places);
    return places;
}

// Whether a number that a row ends with has all its places.
bool is_complete(const std::string &field, int decimals) noexcept {
    const size_t point = field.find('.');
    return decimals > 0 && point != std::string::npos && field.size() - point - 1 >= static_cast<size_t>(decimals);
}

} // namespace

bool is_rule(std::string_view line) noexcept {
    return line.find_first_not_of("-=+|:~ \t\r") == std::string_view::npos &&
           line.find_first_of("-=") != std::string_view::npos;
}

bool ByteColumns::take(std::string_view line) {
    const bool is_line = line.find_first_not_of("= \r") == line.npos && line.find("====== ") == line.npos;
    if (state_ == State::none && !begins_with(line, "Title:") && !(begins_with(line, "======") && is_line) &&
        !is_description(line))
        return false;
    if (is_description(line)) {
        if (state_ == State::notes || state_ == State::rows)
            fail(Status::format, "describes a second table: must be one table per file");
        state_ = State::heading;
    } else if (state_ == State::none) {
        state_ = State::title;
    } else if (state_ == State::heading && line.find("Bytes") != line.npos && line.find("Label") != line.npos) {
        state_ = State::columns;
    } else if (state_ == State::columns && is_rule(line)) {
        state_ = columns_.empty() ? State::columns : State::rows;
    } else if (state_ == State::columns) {
        add_column(line);
    } else if (state_ == State::rows && begins_with(line, "Note")) {
        state_ = State::notes;
    } else if (is_rule(line)) {
        state_ = state_ == State::notes ? State::rows : state_;
    } else {
        return state_ != State::rows;
    }
    return true;
}

// "  15- 23 F9.3   m/s    RV     ?=-99 Radial velocity"; lines without bytes continue an explanation.
void ByteColumns::add_column(std::string_view line) {
    TableColumn column;
    column.first = column.last = take_number(line);
    if (column.first == 0)
        return;
    if (begins_with(line, "-") || begins_with(line.substr(std::min(line.find_first_not_of(' '), line.size())), "-")) {
        line.remove_prefix(line.find('-') + 1);
        column.last = take_number(line);
    }
    const std::vector<std::string> words = split(line, ' ');
    if (words.size() < 3 || column.last < column.first)
        fail(Status::format, "must describe a column: bytes, format, unit, label");
    column.decimals = decimals_of(words[0]);
    column.unit = words[1] == "---" ? "" : words[1];
    column.name = words[2];
    std::string explanation = words.size() > 3 ? words[3] : "";
    if (begins_with(explanation, "[")) // the range of the values
        explanation.erase(0, explanation.find(']') == explanation.npos ? 0 : explanation.find(']') + 1);
    if (begins_with(explanation, "?")) {
        column.optional = true;
        column.null = begins_with(explanation, "?=") ? explanation.substr(2) : "";
    }
    columns_.push_back(std::move(column));
}

std::vector<std::string> fields_at(std::string_view row, const std::vector<TableColumn> &columns) {
    row = row.substr(0, row.find_last_not_of(" \t\r") + 1);
    std::vector<std::string> fields;
    size_t end = 0; // of the columns before
    for (const TableColumn &column : columns) {
        const size_t first = column.first - 1;
        const std::string_view between = row.substr(std::min(end, row.size()), first > end ? first - end : 0);
        if (between.find_first_not_of(" \t|") != std::string_view::npos)
            fail(Status::format, "{%s}: has text before its first byte, %zu: is not aligned as the header states",
                 column.name.c_str(), column.first);
        fields.push_back(first < row.size() ? trimmed(row.substr(first, column.last - first)) : "");
        const bool is_cut = row.size() < column.last && first < row.size() && column.decimals >= 0 &&
                            !is_complete(fields.back(), column.decimals);
        const bool lacks = first >= row.size() && !column.optional && column.decimals != kTextColumn;
        if (is_cut || lacks)
            fail(Status::format, "{%s}: the line ends at byte %zu: must be bytes %zu to %zu", column.name.c_str(),
                 row.size(), column.first, column.last);
        end = column.last;
    }
    return fields;
}

} // namespace toliman::ingest
