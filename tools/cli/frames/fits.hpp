// Owned CFITSIO files, opened and created by plain names. CFITSIO is loaded when it is first used: it needs 35 more
// libraries (of networks), a third of the time in which the program starts.
#pragma once
#include <fitsio.h>

#include "common/common.hpp"

namespace cli {

// The functions of CFITSIO that are used.
struct Cfitsio {
    decltype(&::fits_close_file) close_file;
    decltype(&::fits_create_diskfile) create_diskfile;
    decltype(&::fits_create_img) create_img;
    decltype(&::fits_create_imgll) create_imgll;
    decltype(&::fits_create_memfile) create_memfile;
    decltype(&::fits_create_tbl) create_tbl;
    decltype(&::fits_flush_file) flush_file;
    decltype(&::fits_get_colnum) get_colnum;
    decltype(&::fits_get_errstatus) get_errstatus;
    decltype(&::fits_get_hdu_num) get_hdu_num;
    decltype(&::fits_get_hdu_type) get_hdu_type;
    decltype(&::fits_get_hduaddrll) get_hduaddrll;
    decltype(&::fits_get_img_dim) get_img_dim;
    decltype(&::fits_get_img_sizell) get_img_sizell;
    decltype(&::fits_get_num_rowsll) get_num_rowsll;
    decltype(&::fits_get_version) get_version;
    decltype(&::fits_movabs_hdu) movabs_hdu;
    decltype(&::fits_movnam_hdu) movnam_hdu;
    decltype(&::fits_open_diskfile) open_diskfile;
    decltype(&::fits_read_col) read_col;
    decltype(&::fits_read_img) read_img;
    decltype(&::fits_read_keyword) read_keyword;
    decltype(&::fits_set_compression_type) set_compression_type;
    decltype(&::fits_set_hdustruc) set_hdustruc;
    decltype(&::fits_update_key) update_key;
    decltype(&::fits_write_col) write_col;
    decltype(&::fits_write_img) write_img;
    decltype(&::fits_write_key) write_key;
    decltype(&::fits_write_key_dbl) write_key_dbl;
    decltype(&::fits_write_key_longstr) write_key_longstr;
};

// Throws Failure where the library is not installed.
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
