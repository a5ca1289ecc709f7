# Language level, warnings and output folders; the same for every target.
option(TOLIMAN_TESTS "Build the tests and examples" ON)
set(TOLIMAN_SANITIZE "" CACHE STRING "Sanitizers for every target, e.g. address,undefined")
option(TOLIMAN_COVERAGE "Count the lines and branches of lib/ that run" OFF)
option(TOLIMAN_UNITY "Compile each folder of lib/ and tools/cli as one unit, which parses its headers once" ON)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Kind of build" FORCE)
endif()
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
set(CMAKE_Fortran_MODULE_DIRECTORY ${PROJECT_BINARY_DIR}/fortran)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# No contraction by default: the bits of sums and frames are promised to be the same on every x86-64.
add_compile_options($<$<COMPILE_LANGUAGE:C,CXX>:-ffp-contract=off>)
add_compile_options($<$<COMPILE_LANGUAGE:C,CXX>:-Wall> $<$<COMPILE_LANGUAGE:C,CXX>:-Wextra>
                    $<$<COMPILE_LANGUAGE:C,CXX>:-Wconversion> $<$<COMPILE_LANGUAGE:C,CXX>:-Wshadow>
                    $<$<COMPILE_LANGUAGE:C,CXX>:-Werror>)
# Sanitizers and coverage compile every file alone: each must include what it uses.
if(TOLIMAN_SANITIZE OR TOLIMAN_COVERAGE)
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
  set(TOLIMAN_UNITY OFF)
endif()
# Files with compile definitions of their own remain units of their own.
function(toliman_unite target) # sources with absolute paths
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${TOLIMAN_UNITY} UNITY_BUILD_MODE GROUP)
  foreach(source IN LISTS ARGN)
    get_filename_component(folder ${source} DIRECTORY)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${folder})
    string(MAKE_C_IDENTIFIER ${folder} group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
endfunction()
if(TOLIMAN_SANITIZE)
  # Not Fortran: GCC's sanitizer reports an absent optional argument that is passed on as a null pointer that is read.
  add_compile_options($<$<COMPILE_LANGUAGE:C,CXX>:-fsanitize=${TOLIMAN_SANITIZE}>
                      $<$<COMPILE_LANGUAGE:C,CXX>:-fno-sanitize-recover=all> -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${TOLIMAN_SANITIZE})
endif()
# Python is built without sanitizers, so their runtime and the C++ library that it inspects are preloaded. Memory that
# Python itself keeps is not a leak.
set(toliman_before_python "")
if(TOLIMAN_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  string(REGEX MATCH "[at]" letter "${TOLIMAN_SANITIZE}") # address, thread
  foreach(library IN ITEMS lib${letter}san.so libstdc++.so)
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=${library} OUTPUT_VARIABLE path
                    OUTPUT_STRIP_TRAILING_WHITESPACE)
    list(APPEND preload ${path})
  endforeach()
  list(JOIN preload ":" preload)
  set(toliman_before_python "LD_PRELOAD=${preload};ASAN_OPTIONS=detect_leaks=0")
endif()
# Counters in the library's own code only, inserted before functions are inlined: each branch counts once, and the tests
# take minutes. Counters of kernels may lose increments from several threads.
if(TOLIMAN_COVERAGE)
  set(toliman_counted --coverage -fno-early-inlining -fprofile-exclude-files=^/usr/)
  add_link_options(--coverage)
endif()
