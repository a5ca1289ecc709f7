// Owned CFITSIO files, opened and created by plain names.
#pragma once
#include <fitsio.h>

#include "common/common.hpp"

namespace cli {

struct CloseFits {
    void operator()(fitsfile *file) const noexcept {
        int status = 0;
        fits_close_file(file, &status);
    }
};

using Fits = std::unique_ptr<fitsfile, CloseFits>;

// CFITSIO skips leading blanks and expands a leading ~ even in names of disk files, but not after ./ or /.
inline std::string plain_name(const std::string &path) {
    return path.compare(0, 1, "/") == 0 ? path : "./" + path;
}

inline std::string fits_reason(int status) {
    char text[FLEN_STATUS];
    fits_get_errstatus(status, text);
    return text;
}

} // namespace cli
