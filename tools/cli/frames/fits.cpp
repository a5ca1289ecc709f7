// Finds the functions of CFITSIO.
#include "frames/fits.hpp"

#include "common/failure.hpp"
#include "common/shared_library.hpp"

namespace cli {

namespace {

Cfitsio load() {
    SharedLibrary library(TOLIMAN_CFITSIO);
    Cfitsio functions{};
    library.find("ffclos", functions.close_file);
    library.find("ffdkinit", functions.create_diskfile);
    library.find("ffcrim", functions.create_img);
    library.find("ffcrimll", functions.create_imgll);
    library.find("ffimem", functions.create_memfile);
    library.find("ffcrtb", functions.create_tbl);
    library.find("ffflus", functions.flush_file);
    library.find("ffgcno", functions.get_colnum);
    library.find("ffgerr", functions.get_errstatus);
    library.find("ffghdn", functions.get_hdu_num);
    library.find("ffghdt", functions.get_hdu_type);
    library.find("ffghadll", functions.get_hduaddrll);
    library.find("ffgidm", functions.get_img_dim);
    library.find("ffgiszll", functions.get_img_sizell);
    library.find("ffgnrwll", functions.get_num_rowsll);
    library.find("ffvers", functions.get_version);
    library.find("ffmahd", functions.movabs_hdu);
    library.find("ffmnhd", functions.movnam_hdu);
    library.find("ffdkopn", functions.open_diskfile);
    library.find("ffgcv", functions.read_col);
    library.find("ffgpv", functions.read_img);
    library.find("ffgkey", functions.read_keyword);
    library.find("fits_set_compression_type", functions.set_compression_type);
    library.find("ffrdef", functions.set_hdustruc);
    library.find("ffuky", functions.update_key);
    library.find("ffpcl", functions.write_col);
    library.find("ffppr", functions.write_img);
    library.find("ffpky", functions.write_key);
    library.find("ffpkyd", functions.write_key_dbl);
    library.find("ffpkls", functions.write_key_longstr);
    if (!library.is_complete())
        throw Failure(kExitInternal,
                      std::string("FITS: the library CFITSIO, ") + TOLIMAN_CFITSIO + ", is not installed");
    return functions;
}

} // namespace

const Cfitsio &cfitsio() {
    static const Cfitsio functions = load();
    return functions;
}

} // namespace cli
