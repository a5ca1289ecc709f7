# Third-party libraries of Debian. tools/deps/packages lists the packages that provide them.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
# Libraries that libtoliman links; toliman-config.cmake.in has the same list for programs that link the static library.
pkg_check_modules(TOLIMAN_NEEDS REQUIRED IMPORTED_TARGET fftw3 openblas libcjson zlib erfa expat)
find_library(FFTW3_THREADS fftw3_threads REQUIRED) # only for fftw_make_planner_thread_safe
find_path(LAPACKE_INCLUDE lapacke.h REQUIRED) # only for its declarations: OpenBLAS contains LAPACK
find_path(RANDOM123_INCLUDE Random123/philox.h REQUIRED)
# netCDF reads batches of frames, if it was there when this was built; it is loaded when the first batch is opened.
find_path(NETCDF_INCLUDE netcdf.h)
find_library(NETCDF_LIBRARY netcdf)
# Further libraries that the program links.
pkg_check_modules(CJSON REQUIRED IMPORTED_TARGET libcjson)
pkg_check_modules(ZLIB REQUIRED IMPORTED_TARGET zlib)
# CFITSIO is loaded when the first FITS file is opened, by the name that programs linked with it would have.
find_path(CFITSIO_INCLUDE fitsio.h REQUIRED)
find_library(CFITSIO_LIBRARY cfitsio REQUIRED)
file(REAL_PATH ${CFITSIO_LIBRARY} CFITSIO_SONAME)
string(REGEX MATCH "libcfitsio\\.so\\.[0-9]+" CFITSIO_SONAME ${CFITSIO_SONAME})
if(TOLIMAN_TESTS)
  pkg_check_modules(CMOCKA REQUIRED IMPORTED_TARGET cmocka)
endif()
