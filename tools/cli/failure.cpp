#include "failure.hpp"

#include <new>

namespace cli {

void malformed(const std::string &path, const std::string &why) {
    throw Failure(kExitInput, path + ": " + why);
}

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
        return kExitOutput;
    case TOLIMAN_E_CANCELLED:
        return kExitInterrupted;
    default:
        return kExitInternal;
    }
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
