// Copies members of the same name from a public struct to an internal one, or back: TOLIMAN_COPY(info, grid, f0, df)
// sets info.f0 and info.df to those of grid. A member that one of them lacks, or whose type has another meaning, does
// not compile.
#pragma once
#include <algorithm>
#include <iterator>
#include <type_traits>

namespace toliman::api {

// Integers may differ in size and sign; a truth value becomes 0 or 1.
template <class To, class From> void copy_member(To &to, const From &from) noexcept {
    if constexpr (std::is_array_v<To>) {
        static_assert(sizeof to == sizeof from &&
                      std::is_same_v<std::decay_t<decltype(to[0])>, std::decay_t<decltype(from[0])>>);
        std::copy(std::begin(from), std::end(from), std::begin(to));
    } else {
        static_assert(std::is_same_v<To, From> || (std::is_integral_v<To> && std::is_integral_v<From>));
        to = static_cast<To>(from);
    }
}

} // namespace toliman::api

// 1 to 8 members.
#define TOLIMAN_COPY_1(to, from, member) ::toliman::api::copy_member((to).member, (from).member)
#define TOLIMAN_COPY_2(to, from, member, ...) TOLIMAN_COPY_1(to, from, member), TOLIMAN_COPY_1(to, from, __VA_ARGS__)
#define TOLIMAN_COPY_3(to, from, member, ...) TOLIMAN_COPY_1(to, from, member), TOLIMAN_COPY_2(to, from, __VA_ARGS__)
#define TOLIMAN_COPY_4(to, from, member, ...) TOLIMAN_COPY_1(to, from, member), TOLIMAN_COPY_3(to, from, __VA_ARGS__)
#define TOLIMAN_COPY_5(to, from, member, ...) TOLIMAN_COPY_1(to, from, member), TOLIMAN_COPY_4(to, from, __VA_ARGS__)
#define TOLIMAN_COPY_6(to, from, member, ...) TOLIMAN_COPY_1(to, from, member), TOLIMAN_COPY_5(to, from, __VA_ARGS__)
#define TOLIMAN_COPY_7(to, from, member, ...) TOLIMAN_COPY_1(to, from, member), TOLIMAN_COPY_6(to, from, __VA_ARGS__)
#define TOLIMAN_COPY_8(to, from, member, ...) TOLIMAN_COPY_1(to, from, member), TOLIMAN_COPY_7(to, from, __VA_ARGS__)
#define TOLIMAN_COPY_OF(m1, m2, m3, m4, m5, m6, m7, m8, count, ...) TOLIMAN_COPY_##count
#define TOLIMAN_COPY(to, from, ...) TOLIMAN_COPY_OF(__VA_ARGS__, 8, 7, 6, 5, 4, 3, 2, 1, 0)(to, from, __VA_ARGS__)
