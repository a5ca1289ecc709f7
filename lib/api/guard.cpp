#include "api/guard.hpp"

#include <new>
#include <stdexcept>
#include <system_error>

namespace toliman::api {

// Asked of the arithmetic itself, as the mode has no other portable home.
void require_nearest() {
    const volatile double one = 1, tiny = 0x1p-60;
    if (one + tiny != one || one - tiny != one)
        fail(Status::unsupported, "the thread's rounding mode is not to nearest (fegetround)");
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
    } catch (const std::length_error &) { // a count that no memory holds
        set_last_error("out of memory");
        return TOLIMAN_E_MEMORY;
    } catch (const std::system_error &error) { // a thread or a lock that cannot be had
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

void check_struct_size(const char *name, uint32_t given, size_t oldest, size_t current) {
    constexpr uint32_t kMember = 8; // every published layout ends with a whole one
    if (given < oldest || given > current || given % kMember != 0)
        fail(Status::argument,
             "{%s->struct_size} = %u: must be in [%zu, %zu]; set it with sizeof or the _init function", name, given,
             oldest, current);
}

} // namespace toliman::api
