// Method: a member is read as double, which holds every limit exactly, and written back only as its preset. An integer
// above 2^53 is compared with an error of 2^-53, far from any limit.
#include "api/option.hpp"

#include <cstdio>
#include <cstring>

namespace toliman::api {

namespace {

template <class T> double read(const unsigned char *place) noexcept {
    T value;
    std::memcpy(&value, place, sizeof value);
    return static_cast<double>(value);
}

template <class T> void write(unsigned char *place, double number) noexcept {
    const T value = static_cast<T>(number);
    std::memcpy(place, &value, sizeof value);
}

double number_at(const unsigned char *place, OptionKind kind) noexcept {
    switch (kind) {
    case OptionKind::int32:
        return read<int32_t>(place);
    case OptionKind::uint32:
        return read<uint32_t>(place);
    case OptionKind::int64:
        return read<int64_t>(place);
    case OptionKind::uint64:
        return read<uint64_t>(place);
    case OptionKind::real:
        break;
    }
    return read<double>(place);
}

void set_number(unsigned char *place, OptionKind kind, double number) noexcept {
    switch (kind) {
    case OptionKind::int32:
        return write<int32_t>(place, number);
    case OptionKind::uint32:
        return write<uint32_t>(place, number);
    case OptionKind::int64:
        return write<int64_t>(place, number);
    case OptionKind::uint64:
        return write<uint64_t>(place, number);
    case OptionKind::real:
        return write<double>(place, number);
    }
}

size_t size_of(OptionKind kind) noexcept {
    return kind == OptionKind::int32 || kind == OptionKind::uint32 ? 4 : 8;
}

bool is_allowed(double number, const OptionRule &rule) noexcept {
    if ((rule.marks & kZero) != 0 && number == 0)
        return true;
    if ((rule.marks & kFlags) != 0)
        return (static_cast<uint32_t>(number) & ~static_cast<uint32_t>(rule.most)) == 0;
    const bool above = (rule.marks & kOpenLeast) != 0 ? number > rule.least : number >= rule.least;
    const bool below = (rule.marks & kOpenMost) != 0 ? number < rule.most : number <= rule.most;
    return above && below;
}

[[noreturn]] void refuse(double number, const OptionRule &rule, const char *name, size_t element) {
    char index[24] = "";
    if (rule.count > 1)
        std::snprintf(index, sizeof index, "[%zu]", element);
    fail(Status::argument, "{%s->%s%s} = %.15g: must be %s", name, rule.member, index, number, rule.allowed);
}

} // namespace

void complete(void *options, const char *name, const OptionRule *rules, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const OptionRule &rule = rules[i];
        unsigned char *place = static_cast<unsigned char *>(options) + rule.offset;
        for (size_t element = 0; element < rule.count; element++, place += size_of(rule.kind)) {
            const double number = number_at(place, rule.kind);
            if (!is_allowed(number, rule))
                refuse(number, rule, name, element);
            if (number == 0 && rule.preset != 0)
                set_number(place, rule.kind, rule.preset);
        }
    }
}

} // namespace toliman::api
