// The options structs of callers.
#pragma once
#include <iterator>

#include "api/guard.hpp"
#include "api/option_rules.hpp"

namespace toliman::api {

// Returns a copy of the caller's struct. Members that the caller's struct lacks are 0, their default; NULL: all are.
template <class T> T copied(const T *given, const char *name) {
    T known = {};
    if (given != nullptr) {
        check_struct_size(name, *given);
        __builtin_memcpy(&known, given, given->struct_size);
    }
    return known;
}

// Returns a copy of the caller's options, checked and completed by the rules of their struct.
template <class T> T accept(const T *options, const char *name) {
    T known = copied(options, name);
    if (OptionRules<T>::kRules[0].member != nullptr)
        complete(&known, name, OptionRules<T>::kRules, std::size(OptionRules<T>::kRules));
    return known;
}

} // namespace toliman::api
