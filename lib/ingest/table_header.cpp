// Method: a table is a header, then rows. Each line of the header either is recognised by its first characters (bars
// and backslashes of IPAC, the title of a byte-by-byte description, the comments of ECSV) or by its fields: a line of
// names has no number, and below the names a line of units has a known unit and no number, a line of types only types.
// The first other line is a row. Nothing is guessed from later lines, so that a table can be read while it grows.
// References: IPAC table format; CDS and AAS machine-readable tables (byte_columns.cpp); ECSV (ecsv.cpp); rdb of
// Starbase.
#include "ingest/table_header.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "ingest/column_names.hpp"
#include "ingest/ecsv.hpp"
#include "ingest/fields.hpp"
#include "ingest/unit.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kFewestNames = 2, kMostComments = 8, kMostColumns = 4096, kMostEcsv = 1 << 18;

bool begins_with(std::string_view text, char c) noexcept {
    const size_t first = text.find_first_not_of(kSpace);
    return first != std::string_view::npos && text[first] == c;
}

bool is_number(const std::string &field) {
    double number = 0;
    return number_of(field, number) && !is_missing(field);
}

bool are_names(const std::vector<std::string> &fields) {
    return fields.size() >= kFewestNames && is_column_name(fields[0]) && is_column_name(fields[1]) &&
           std::none_of(fields.begin(), fields.end(), is_number);
}

// 8N, S, 10.3N: widths and types of rdb.
bool is_rdb_type(const std::string &field) {
    const size_t type = field.find_first_not_of("0123456789.");
    return !field.empty() && type + 1 == field.size() && std::string("NSMDnsmd").find(field[type]) != std::string::npos;
}

bool is_type(const std::string &field) {
    static const std::string types[] = {"double", "float", "real",   "int",    "integer", "long",    "short",
                                        "char",   "str",   "string", "bool",   "date",    "float64", "float32",
                                        "int64",  "int32", "int16",  "object", "text",    "number"};
    return std::find(std::begin(types), std::end(types), lower(field)) != std::end(types);
}

} // namespace

void TableHeader::comment(std::string_view line) {
    line.remove_prefix(line.find('#') + 1);
    if (trimmed(line).compare(0, 5, "%ECSV") == 0) {
        if (named_ || rows_)
            fail(Status::format, "begins a second table: must be one table per file");
        is_ecsv_ = true;
    }
    if (rows_)
        return;
    if (is_ecsv_ && ecsv_.size() + line.size() < kMostEcsv)
        ecsv_ += std::string(line.substr(line.substr(0, 1) == " " ? 1 : 0)) + '\n';
    const size_t first = line.find_first_not_of("# \t\r");
    if (first == line.npos)
        return;
    if (comments_.size() == kMostComments)
        comments_.erase(comments_.begin());
    comments_.emplace_back(line.substr(first));
}

TableHeader::Line TableHeader::take(std::string_view line) {
    if (rows_)
        return (is_rule(line) &&
                std::count_if(line.begin(), line.end(), [](char c) { return c == '-' || c == '='; }) > 2) ||
                       (is_ipac_ && begins_with(line, '\\'))
                   ? Line::skipped
                   : Line::row;
    if ((!named_ || bytes_.is_used()) && bytes_.take(line)) {
        const bool is_end = bytes_.is_described() && !named_;
        if (is_end)
            columns_ = bytes_.columns();
        named_ = named_ || is_end;
        return is_end ? Line::names : Line::skipped;
    }
    if (bytes_.is_used())
        return Line::row;
    if (begins_with(line, '\\') || is_rule(line))
        return Line::skipped;
    if (begins_with(line, '|'))
        return take_bars(line);
    if (named_)
        return is_extension(line) ? Line::skipped : Line::row;
    const EcsvHeader ecsv = is_ecsv_ ? parse_ecsv(ecsv_) : EcsvHeader();
    const char separator = is_ecsv_ ? ecsv.delimiter : separator_of(line);
    const std::vector<std::string> names = split_names(without_remark(line), separator);
    if (!are_names(names))
        return Line::row;
    separator_ = separator;
    set_names(names);
    named_ = true;
    for (TableColumn &column : columns_)
        for (const auto &[name, unit] : ecsv.units)
            column.unit = name == column.name && !unit.empty() ? unit : column.unit;
    return Line::names;
}

// Names, types, units and null values of IPAC; rows of tables that have bars between all fields.
TableHeader::Line TableHeader::take_bars(std::string_view line) {
    const std::vector<std::string> fields = split(line, '|');
    if (!named_ && are_names(fields)) {
        separator_ = '|';
        set_names(fields);
        named_ = true;
        size_t bar = line.find('|');
        for (TableColumn &column : columns_) {
            const size_t next = std::min(line.find('|', bar + 1), line.size());
            column.first = bar + 2;
            column.last = next;
            bar = next;
        }
        return Line::names;
    }
    if (!named_)
        return Line::row;
    bar_lines_++;
    if (is_extension(line))
        return Line::skipped;
    if (!is_ipac_ || fields.size() != columns_.size())
        return Line::row;
    for (size_t i = 0; i < fields.size() && bar_lines_ == 3; i++)
        columns_[i].null = fields[i];
    return Line::skipped;
}

// Whether a line below the names has types, widths or units.
bool TableHeader::is_extension(std::string_view line) {
    const std::vector<std::string> fields = split_names(line, separator_);
    if (fields.size() != columns_.size())
        return false;
    const auto all = [&](auto test) { return std::all_of(fields.begin(), fields.end(), test); };
    if (all(is_type)) {
        is_ipac_ = separator_ == '|';
        for (size_t i = 0; i < fields.size(); i++)
            columns_[i].decimals = lower(fields[i]) == "char" ? kTextColumn : columns_[i].decimals;
        return true;
    }
    return all(is_rdb_type) || all([](const std::string &field) { return is_rule(field); }) || set_units(fields);
}

bool TableHeader::set_units(const std::vector<std::string> &fields) {
    const auto is_unit = [](const std::string &field) { return unit_of(field).quantity != Quantity::unknown; };
    if (std::any_of(fields.begin(), fields.end(), is_number) || std::none_of(fields.begin(), fields.end(), is_unit))
        return false;
    for (size_t i = 0; i < fields.size(); i++)
        columns_[i].unit = columns_[i].unit.empty() ? fields[i] : columns_[i].unit;
    return true;
}

void TableHeader::set_width(size_t width) {
    if (width > kMostColumns)
        fail(Status::format, "has %zu columns: must be at most %zu", width, kMostColumns);
    columns_.assign(width, {});
}

void TableHeader::set_names(const std::vector<std::string> &names) {
    set_width(names.size());
    for (size_t i = 0; i < names.size(); i++) {
        columns_[i].name = names[i];
        columns_[i].unit = split_unit(names[i]).unit;
    }
}

std::vector<std::string> TableHeader::names() const {
    std::vector<std::string> names;
    for (const TableColumn &column : columns_)
        names.push_back(column.name);
    return names;
}

// A comment as names, by each separator that gives as many.
std::vector<std::vector<std::string>> TableHeader::readings(const std::string &comment, size_t width) const {
    std::vector<std::vector<std::string>> readings;
    for (const char separator : {separator_, ',', ';', '\t', '|', ' '}) {
        std::vector<std::string> names = split_names(comment, separator);
        if (names.size() == width && std::none_of(names.begin(), names.end(), is_number))
            readings.push_back(std::move(names));
    }
    return readings;
}

std::vector<std::string> TableHeader::fields(std::string_view row) {
    if (bytes_.is_used())
        return fields_at(row, columns_);
    const bool has_bars = begins_with(row, '|');
    if (separator_ == '|' && named_ && !has_bars && columns_[0].first > 0) {
        const auto is_blank = [&](const TableColumn &column) {
            return row.size() < column.first - 1 ||
                   std::string(kSpace).find(row[column.first - 2]) != std::string::npos;
        };
        const bool aligned = std::all_of(columns_.begin(), columns_.end(), is_blank);
        return aligned ? fields_at(row, columns_) : split(row, ' ');
    }
    row = without_remark(row);
    if (!rows_ && !named_)
        separator_ = has_bars ? '|' : separator_of(row);
    const std::string line = without_plus_minus(row, separator_);
    for (const char other : {'\t', ' '}) // below names that are separated by tabs or blanks
        if (!rows_ && named_ && (separator_ == '\t' || separator_ == ' ') &&
            split(line, separator_).size() != columns_.size() && split(line, other).size() == columns_.size())
            separator_ = other;
    return split(line, separator_);
}

} // namespace toliman::ingest
