// Format: a ledger's header lists its columns by type and name: those of every ledger, then the additional values of
// the estimator, then the covariances cov_A_B of all pairs of values, except the variance of the first, which is
// sigma^2, then its parameters.
// Why: records keep one fixed size per ledger, so that record n is found without an index, while estimators differ in
// what they measure. A cell without a number holds NaN, or 0 in an integer column.
#include "track/columns.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/words.hpp"

namespace toliman::track {

namespace {

constexpr size_t kLongestValue = 24, kNameSize = Columns::kSavedSize - 8;
constexpr char kFirstValue[] = "value", kCovariance[] = "cov_";

struct Own {
    const char *name;
    ColumnType type;
};
constexpr Own kOwn[kOwnColumns] = {{"chi_square", ColumnType::f64},       {"exposure_s", ColumnType::f64},
                                   {"shift_s", ColumnType::f64},          {"window_row", ColumnType::i64},
                                   {"window_col", ColumnType::i64},       {"flags", ColumnType::i64},
                                   {"intervals", ColumnType::i64},        {"chi_square_sigma", ColumnType::f64},
                                   {"largest_residual", ColumnType::f64}, {"bad_pixels", ColumnType::i64},
                                   {"factor", ColumnType::f64},           {"geometric_arcsec", ColumnType::f64},
                                   {"d_period_years", ColumnType::f64},   {"d_semi_major_arcsec", ColumnType::f64},
                                   {"d_eccentricity", ColumnType::f64},   {"d_inclination_deg", ColumnType::f64},
                                   {"d_node_deg", ColumnType::f64},       {"d_periastron_deg", ColumnType::f64},
                                   {"d_epoch", ColumnType::f64}};

bool is_column_name(std::string_view name, size_t longest) noexcept {
    const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
    return !name.empty() && name.size() <= longest && std::all_of(name.begin(), name.end(), allowed);
}

} // namespace

const char *name_of(OwnColumn column) noexcept {
    return kOwn[static_cast<size_t>(column)].name;
}

uint64_t Column::empty() const noexcept {
    return type == ColumnType::f64 ? with_bits<uint64_t>(std::numeric_limits<double>::quiet_NaN()) : 0;
}

double Column::number(uint64_t cell) const noexcept {
    return type == ColumnType::f64 ? with_bits<double>(cell) : static_cast<double>(static_cast<int64_t>(cell));
}

Columns::Columns(std::string_view further, bool reduced, std::string_view parameters) {
    for (size_t i = 0; i < (reduced ? kOwnColumns : static_cast<size_t>(OwnColumn::factor)); i++)
        add(kOwn[i].name, kOwn[i].type, ColumnRole::own);
    std::vector<std::string> names = words_of(further);
    for (const std::string &name : names) {
        if (!is_column_name(name, kLongestValue) || name == kFirstValue || name.rfind(kCovariance, 0) == 0 ||
            find(name) < count())
            fail(Status::argument,
                 "{options->estimator.values}: \"%.40s\": must be a unique name of 1 to %zu characters a-z 0-9 _, not "
                 "\"value\" "
                 "and not beginning with \"cov_\"",
                 name.c_str(), kLongestValue);
        if (values() == kMaxValues)
            fail(Status::argument, "{options->estimator.values}: must name at most %zu values beyond the first",
                 kMaxValues - 1);
        add(name, ColumnType::f64, ColumnRole::value);
    }
    names.insert(names.begin(), kFirstValue);
    for (size_t i = 0; i < names.size(); i++)
        for (size_t j = std::max<size_t>(i, 1); j < names.size(); j++)
            add(kCovariance + names[i] + "_" + names[j], ColumnType::f64, ColumnRole::covariance);
    for (const std::string &name : words_of(parameters))
        add(name, ColumnType::f64, ColumnRole::parameter);
}

void Columns::add(std::string name, ColumnType type, ColumnRole role) {
    is_reduced_ = is_reduced_ || name == name_of(OwnColumn::factor);
    has_intervals_ = has_intervals_ || name == name_of(OwnColumn::intervals);
    all_.push_back({std::move(name), type, role});
}

Columns Columns::load(ByteReader &in, size_t count) {
    Columns columns;
    columns.all_.clear();
    columns.is_reduced_ = columns.has_intervals_ = false;
    for (size_t i = 0; i < count; i++) {
        char name[kNameSize + 1] = {};
        std::memcpy(name, in.raw(kNameSize), kNameSize);
        const uint32_t type = in.u32(), role = in.u32();
        if (!is_column_name(name, kNameSize - 1) || columns.find(name) < columns.count())
            fail(Status::format, "column %zu: name is invalid or duplicate", i);
        if (type > 1 || role < 1 || role > 4)
            fail(Status::format, "column %s: type %u, role %u: written by a later version?", name, type, role);
        columns.add(name, static_cast<ColumnType>(type), static_cast<ColumnRole>(role));
    }
    if (columns.values() > kMaxValues)
        fail(Status::format, "%zu values of an estimator: must be at most %zu", columns.values(), kMaxValues);
    return columns;
}

void Columns::save(ByteWriter &out) const {
    for (const Column &column : all_) {
        char name[kNameSize] = {};
        column.name.copy(name, kNameSize - 1);
        out.raw(name, sizeof name);
        out.u32(static_cast<uint32_t>(column.type));
        out.u32(static_cast<uint32_t>(column.role));
    }
}

size_t Columns::find(std::string_view name) const noexcept {
    size_t at = 0;
    while (at < all_.size() && all_[at].name != name)
        at++;
    return at;
}

size_t Columns::own() const noexcept {
    return static_cast<size_t>(
        std::count_if(all_.begin(), all_.end(), [](const Column &one) { return one.role == ColumnRole::own; }));
}

size_t Columns::values() const noexcept {
    size_t count = 1;
    for (const Column &column : all_)
        count += column.role == ColumnRole::value;
    return count;
}

std::string Columns::names_of(ColumnRole role) const {
    std::string list;
    for (const Column &column : all_)
        if (column.role == role)
            list += (list.empty() ? "" : " ") + column.name;
    return list;
}

std::string Columns::further() const {
    return names_of(ColumnRole::value);
}

std::string Columns::parameters() const {
    return names_of(ColumnRole::parameter);
}

Cells Columns::empty() const noexcept {
    Cells cells = {};
    for (size_t i = 0; i < all_.size(); i++)
        cells[i] = all_[i].empty();
    return cells;
}

Arrangement::Arrangement(const Columns &from, const Columns &to) : empty_(to.empty()) {
    for (const Column &column : to.all()) {
        const size_t at = from.find(column.name);
        from_.push_back(at < from.count() && from.all()[at].type == column.type ? at : kMaxColumns);
    }
}

Cells Arrangement::operator()(const Cells &cells) const noexcept {
    Cells arranged = empty_;
    for (size_t i = 0; i < from_.size(); i++)
        if (from_[i] < kMaxColumns)
            arranged[i] = cells[from_[i]];
    return arranged;
}

} // namespace toliman::track
