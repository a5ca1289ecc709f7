// FFTW3.
#pragma once

namespace toliman::fft {

// Version text of the library in use.
const char *version() noexcept;

} // namespace toliman::fft
