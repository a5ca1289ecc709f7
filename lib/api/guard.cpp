// Method: guard() catches everything and maps it to a status code and the thread-local last message, because an
// exception must not cross the C boundary. std::bad_alloc and std::length_error are out-of-memory; std::system_error
// comes from thread creation, an exhausted resource; anything unknown is a bug, TOLIMAN_E_INTERNAL. Messages are stored
// in fixed arrays (base/error.hpp), so that reporting out-of-memory allocates nothing.
#include "api/guard.hpp"

#include <new>
#include <stdexcept>
#include <system_error>

namespace toliman::api {

// Tests the arithmetic itself: 1 + 2^-60 and 1 - 2^-60 both round to 1 in round-to-nearest only. volatile prevents
// constant folding.
void require_nearest() {
    const volatile double one = 1, tiny = 0x1p-60;
    if (one + tiny != one || one - tiny != one)
        fail(Status::unsupported,
             "the thread's floating-point rounding mode must be round-to-nearest (see fesetround)");
}

toliman_status status_of_exception() noexcept {
    try {
        throw;
    } catch (const Error &error) {
        set_last_error(error.what(), error.field());
        return static_cast<toliman_status>(error.status());
    } catch (const std::bad_alloc &) {
        set_last_error("out of memory");
        return TOLIMAN_E_MEMORY;
    } catch (const std::length_error &) { // a container larger than the address space
        set_last_error("out of memory");
        return TOLIMAN_E_MEMORY;
    } catch (const std::system_error &error) { // a thread or lock cannot be created
        set_last_error(error.what());
        return TOLIMAN_E_MEMORY;
    } catch (const std::exception &error) {
        set_last_error(error.what());
        return TOLIMAN_E_INTERNAL;
    } catch (...) {
        set_last_error("unknown exception");
        return TOLIMAN_E_INTERNAL;
    }
}

void check_again(toliman_status status) {
    if (status != TOLIMAN_OK)
        throw Error(static_cast<Status>(status), toliman_last_error(), toliman_last_error_field());
}

void check_struct_size(const char *name, uint32_t given, size_t oldest, size_t current) {
    constexpr uint32_t kMember = 8; // every published layout ends on an 8-byte boundary
    if (given < oldest || given > current || given % kMember != 0)
        fail(Status::argument, "{%s->struct_size} = %u: must be in [%zu, %zu]; set it with sizeof or the _INIT macro",
             name, given, oldest, current);
}

} // namespace toliman::api
