// Owned CFITSIO files, opened and created by plain names. CFITSIO is loaded when it is first used: it needs 35 more
// libraries (of networks), a third of the time in which the program starts.
#pragma once
#include <fitsio.h>

#include "common/common.hpp"
#include "common/shared_library.hpp"

namespace cli {

// The functions of CFITSIO that are used.
struct Cfitsio {
    Cfitsio(); // throws Failure where the library is not installed
    SharedLibrary library;
    decltype(&::fits_close_file) close_file = library.find("ffclos");
    decltype(&::fits_create_diskfile) create_diskfile = library.find("ffdkinit");
    decltype(&::fits_create_img) create_img = library.find("ffcrim");
    decltype(&::fits_create_imgll) create_imgll = library.find("ffcrimll");
    decltype(&::fits_create_memfile) create_memfile = library.find("ffimem");
    decltype(&::fits_create_tbl) create_tbl = library.find("ffcrtb");
    decltype(&::fits_flush_file) flush_file = library.find("ffflus");
    decltype(&::fits_get_colnum) get_colnum = library.find("ffgcno");
    decltype(&::fits_get_errstatus) get_errstatus = library.find("ffgerr");
    decltype(&::fits_get_hdu_num) get_hdu_num = library.find("ffghdn");
    decltype(&::fits_get_hdu_type) get_hdu_type = library.find("ffghdt");
    decltype(&::fits_get_hduaddrll) get_hduaddrll = library.find("ffghadll");
    decltype(&::fits_get_img_dim) get_img_dim = library.find("ffgidm");
    decltype(&::fits_get_img_sizell) get_img_sizell = library.find("ffgiszll");
    decltype(&::fits_get_num_rowsll) get_num_rowsll = library.find("ffgnrwll");
    decltype(&::fits_get_version) get_version = library.find("ffvers");
    decltype(&::fits_movabs_hdu) movabs_hdu = library.find("ffmahd");
    decltype(&::fits_movnam_hdu) movnam_hdu = library.find("ffmnhd");
    decltype(&::fits_open_diskfile) open_diskfile = library.find("ffdkopn");
    decltype(&::fits_read_col) read_col = library.find("ffgcv");
    decltype(&::fits_read_img) read_img = library.find("ffgpv");
    decltype(&::fits_read_keyword) read_keyword = library.find("ffgkey");
    decltype(&::fits_set_compression_type) set_compression_type = library.find("fits_set_compression_type");
    decltype(&::fits_set_hdustruc) set_hdustruc = library.find("ffrdef");
    decltype(&::fits_update_key) update_key = library.find("ffuky");
    decltype(&::fits_write_col) write_col = library.find("ffpcl");
    decltype(&::fits_write_img) write_img = library.find("ffppr");
    decltype(&::fits_write_key) write_key = library.find("ffpky");
    decltype(&::fits_write_key_dbl) write_key_dbl = library.find("ffpkyd");
    decltype(&::fits_write_key_longstr) write_key_longstr = library.find("ffpkls");
};

const Cfitsio &cfitsio();

struct CloseFits {
    void operator()(fitsfile *file) const noexcept {
        int status = 0;
        cfitsio().close_file(file, &status);
    }
};

using Fits = std::unique_ptr<fitsfile, CloseFits>;

// CFITSIO skips leading blanks and expands a leading ~ even in names of disk files, but not after ./ or /.
inline std::string plain_name(const std::string &path) {
    return path.compare(0, 1, "/") == 0 ? path : "./" + path;
}

inline std::string fits_reason(int status) {
    char text[FLEN_STATUS];
    cfitsio().get_errstatus(status, text);
    return text;
}

} // namespace cli
