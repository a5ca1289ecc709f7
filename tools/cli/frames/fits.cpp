// Finds the functions of CFITSIO.
#include "frames/fits.hpp"

namespace cli {

Cfitsio::Cfitsio() : library(TOLIMAN_CFITSIO) {
    if (!library.is_complete())
        throw Failure(kExitInternal,
                      std::string("FITS: the library CFITSIO, ") + TOLIMAN_CFITSIO + ", is not installed");
}

const Cfitsio &cfitsio() {
    static const Cfitsio functions;
    return functions;
}

} // namespace cli
