# Debian's packages, each wrapped once. tools/deps/packages lists what provides them.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
# What the library is made of; toliman-config.cmake.in has the same for programs that link the static one.
pkg_check_modules(TOLIMAN_NEEDS REQUIRED IMPORTED_TARGET fftw3 openblas libcjson zlib)
find_library(FFTW3_THREADS fftw3_threads REQUIRED) # only for its thread-safe planner
find_path(LAPACKE_INCLUDE lapacke.h REQUIRED) # only for declarations: OpenBLAS has LAPACK
find_path(RANDOM123_INCLUDE Random123/philox.h REQUIRED)
# What the program takes besides.
pkg_check_modules(CJSON REQUIRED IMPORTED_TARGET libcjson)
pkg_check_modules(ZLIB REQUIRED IMPORTED_TARGET zlib)
pkg_check_modules(CFITSIO REQUIRED IMPORTED_TARGET cfitsio)
pkg_check_modules(PNG REQUIRED IMPORTED_TARGET libpng)
if(TOLIMAN_TESTS)
  pkg_check_modules(CMOCKA REQUIRED IMPORTED_TARGET cmocka)
endif()
