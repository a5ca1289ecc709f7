#include "backend/fft.hpp"

#include <fftw3.h>

namespace toliman::fft {

const char *version() noexcept {
    return fftw_version;
}

} // namespace toliman::fft
