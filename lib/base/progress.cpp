#include "base/progress.hpp"

#include <cstdarg>

#include "base/text.hpp"

namespace toliman {

namespace {
constexpr int32_t kLevelWarning = 22; // TOLIMAN_LOG_WARNING
} // namespace

void Log::warn(const char *format, ...) const {
    if (call == nullptr)
        return;
    char text[kErrorTextSize];
    va_list arguments;
    va_start(arguments, format);
    print_text(text, sizeof text, format, arguments);
    va_end(arguments);
    in_callback("log", [&] { call(kLevelWarning, text, user_data); });
}

} // namespace toliman
