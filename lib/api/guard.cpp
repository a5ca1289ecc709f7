#include "api/guard.hpp"

namespace toliman::api {

void check_struct_size(const char *name, uint32_t given, size_t oldest, size_t current) {
    constexpr uint32_t kMember = 8; // every published layout ends with a whole one
    if (given < oldest || given > current || given % kMember != 0)
        fail(Status::argument, "%s->struct_size = %u: must be in [%zu, %zu]; set it with sizeof or the _init function",
             name, given, oldest, current);
}

} // namespace toliman::api
