// Tests the guard of the C interface: every exception becomes a status code and a message, and none escapes.
#include <cfenv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <system_error>

#include "api/guard.hpp"

namespace {

using namespace toliman;

template <class Body> void require(toliman_status expected, const char *message, Body body) {
    const toliman_status status = api::guard(body);
    if (status != expected || std::strstr(toliman_last_error(), message) == nullptr) {
        std::fprintf(stderr, "%s: %s, not %s: %s\n", toliman_constant_name(status), toliman_last_error(),
                     toliman_constant_name(expected), message);
        std::exit(EXIT_FAILURE);
    }
}

} // namespace

int main() {
    require(TOLIMAN_E_CAPACITY, "size = 3", [] { fail(Status::capacity, "size = %d", 3); });
    require(TOLIMAN_OK, "size = 3", [] {});
    require(TOLIMAN_E_MEMORY, "out of memory", [] { throw std::bad_alloc(); });
    require(TOLIMAN_E_MEMORY, "temporarily unavailable",
            [] { throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again)); });
    require(TOLIMAN_E_MEMORY, "out of memory", [] { throw std::length_error("too long"); });
    require(TOLIMAN_E_INTERNAL, "odd", [] { throw std::logic_error("odd"); });
    require(TOLIMAN_E_INTERNAL, "unknown exception", [] { throw 7; });

    bool ran = false;
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
        std::fesetround(mode);
        require(TOLIMAN_E_UNSUPPORTED, "rounding mode", [&] { ran = true; });
    }
    std::fesetround(FE_TONEAREST);
    require(ran ? TOLIMAN_E_INTERNAL : TOLIMAN_OK, "", [] {});
    return EXIT_SUCCESS;
}
