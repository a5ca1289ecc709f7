#include "common/failure.hpp"

#include <new>

#include "common/common.hpp"

namespace cli {

namespace {

// Replaces control characters, which names and values in files may contain and a terminal would execute.
std::string printable(std::string text) {
    for (char &byte : text)
        byte = static_cast<unsigned char>(byte) < ' ' || byte == '\x7f' ? '?' : byte;
    return text;
}

// The exit code for the status of a failed library call.
ExitCode exit_code(toliman_status status) noexcept {
    switch (status) {
    case TOLIMAN_OK:
        return kExitOk;
    case TOLIMAN_E_ARGUMENT:
    case TOLIMAN_E_SCENE:
    case TOLIMAN_E_UNSUPPORTED:
    case TOLIMAN_E_RANGE:
    case TOLIMAN_E_MISMATCH:
    case TOLIMAN_E_STATE:
    case TOLIMAN_E_CAPACITY:
        return kExitUsage;
    case TOLIMAN_E_NOT_FOUND:
    case TOLIMAN_E_FORMAT:
        return kExitInput;
    case TOLIMAN_E_WRITE:
    case TOLIMAN_E_LOST:
        return kExitOutput;
    case TOLIMAN_E_CANCELLED:
        return kExitInterrupted;
    default:
        return kExitInternal;
    }
}

} // namespace

Failure::Failure(ExitCode code, const std::string &text) : std::runtime_error(printable(text)), code_(code) {}

void malformed(const std::string &path, const std::string &why) {
    throw Failure(kExitInput, path + ": " + why);
}

void refuse_mistakes(Mistakes mistakes) {
    for (const auto &[is_made, text] : mistakes)
        if (is_made)
            throw Failure(kExitUsage, text);
}

std::string message_about(const std::string &name, const toliman::error &error) {
    const std::string what = error.what(), equals = " = ";
    const size_t place = what.find(error.field());
    if (error.field().empty() || place == std::string::npos)
        return name + ": " + what;
    std::string detail = what.substr(place + error.field().size());
    if (detail.compare(0, equals.size(), equals) == 0)
        detail.erase(1, 2);
    return what.substr(0, place) + name + detail;
}

void refuse_option(const toliman::error &error, OptionNames names) {
    const std::string field = error.field().substr(0, error.field().find('['));
    for (const auto &[member, option] : names)
        if (field == std::string("options->") + member)
            throw Failure(kExitUsage, message_about(option, error));
}

Ending ending_of(const std::function<void()> &work) {
    try {
        work();
        return {};
    } catch (const Failure &failure) {
        return {failure.code(), failure.what()};
    } catch (const toliman::error &error) {
        return {exit_code(error.status()), error.what()};
    } catch (const std::bad_alloc &) {
        return {kExitInternal, "out of memory"};
    } catch (const std::exception &error) {
        return {kExitInternal, error.what()};
    }
}

} // namespace cli
