// Tests arrays of structs from callers with an older header: the stride is the caller's struct size, and members that
// the caller does not know are 0 or left out.
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "api/struct_array.hpp"

namespace {

struct Now {
    uint32_t struct_size;
    int32_t number;
    int64_t place;
    double added;
};

struct Then {
    uint32_t struct_size;
    int32_t number;
    int64_t place;
};

void require(bool is_true, const char *what) {
    if (!is_true) {
        std::fprintf(stderr, "not so: %s\n", what);
        std::exit(EXIT_FAILURE);
    }
}

bool is_refused(uint32_t size) {
    Now one = {size, 0, 0, 0};
    try {
        toliman::api::StructArray<Now>(&one, "array");
    } catch (const toliman::Error &) {
        return true;
    }
    return false;
}

} // namespace

template <> inline constexpr size_t toliman::api::kOldest<Now> = offsetof(Now, added);

int main() {
    Then then[3] = {{sizeof(Then), 1, 10}, {0, 2, 20}, {0, 3, 30}};
    const toliman::api::StructArray<const Now> given(reinterpret_cast<const Now *>(then), "array");
    for (size_t i = 0; i < 3; i++) {
        const Now got = given.get(i);
        require(got.number == then[i].number && got.place == then[i].place && got.added == 0, "get of an older caller");
    }
    const toliman::api::StructArray<Now> callers(reinterpret_cast<Now *>(then), "array");
    callers.put(1, {99, 5, 50, 0.5});
    require(then[1].struct_size == sizeof(Then) && then[1].number == 5 && then[1].place == 50,
            "put to an older caller");
    require(then[0].number == 1 && then[2].number == 3 && then[2].struct_size == 0, "its neighbours are untouched");

    Now now[2] = {{sizeof(Now), 0, 0, 0}, {}};
    toliman::api::StructArray<Now>(now, "array").put(1, {0, 7, 70, 0.7});
    require(now[1].added == 0.7 && now[1].struct_size == sizeof(Now), "put to a caller of today");

    require(is_refused(0) && is_refused(sizeof(Then) - 8) && is_refused(sizeof(Now) + 8), "sizes never published");
    return EXIT_SUCCESS;
}
