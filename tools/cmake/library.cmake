# libtoliman.so and libtoliman.a from the same objects; hot kernels are compiled once per instruction set.
configure_file(include/toliman/version.h.in ${PROJECT_BINARY_DIR}/include/toliman/version.h @ONLY)

file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lib/*/*.cpp ${PROJECT_SOURCE_DIR}/lib/*/*/*.cpp)
# Compiled once per instruction set, inside a namespace of that name; kernels/isa.cpp selects one at run time.
file(GLOB isa_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lib/kernels/*.isa.cpp)
list(REMOVE_ITEM sources ${isa_sources})

add_library(toliman_settings INTERFACE)
target_include_directories(toliman_settings INTERFACE ${PROJECT_SOURCE_DIR}/lib ${PROJECT_SOURCE_DIR}/include
                           ${PROJECT_BINARY_DIR}/include ${PROJECT_BINARY_DIR}/generated)
target_include_directories(toliman_settings SYSTEM INTERFACE ${RANDOM123_INCLUDE} ${LAPACKE_INCLUDE})
target_compile_options(toliman_settings INTERFACE -fvisibility=hidden -ffunction-sections -fdata-sections
                       $<$<COMPILE_LANGUAGE:CXX>:-fvisibility-inlines-hidden>
                       $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CXX_COMPILER_ID:GNU>>:-fno-gnu-unique>)

add_library(toliman_objects OBJECT ${sources})
toliman_unite(toliman_objects ${sources})
# Programs of tests replace it.
set_source_files_properties(${PROJECT_SOURCE_DIR}/lib/kernels/isa.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
add_dependencies(toliman_objects toliman_generated) # lib/api includes struct_sizes.hpp
set(toliman_needs fftw3_threads PkgConfig::TOLIMAN_NEEDS Threads::Threads)
target_link_libraries(toliman_objects PRIVATE toliman_settings ${toliman_needs})
# Parsed once, as most files include them.
set(toliman_common_headers <algorithm> <array> <cmath> <cstdint> <cstring> <functional> <map> <memory> <optional> <string>
                           <string_view> <utility> <vector>)
target_precompile_headers(toliman_objects PRIVATE ${toliman_common_headers})
# Every exported function has a declaration, and so that of its header (tools/check/exports).
target_compile_options(toliman_objects PRIVATE ${toliman_counted}
                       $<IF:$<CXX_COMPILER_ID:GNU>,-Wmissing-declarations,-Wmissing-prototypes>
                       $<$<BOOL:${TOLIMAN_COVERAGE}>:-fprofile-update=atomic>)

if(NETCDF_INCLUDE AND NETCDF_LIBRARY)
  file(REAL_PATH ${NETCDF_LIBRARY} netcdf)
  get_filename_component(netcdf ${netcdf} NAME) # libnetcdf.so.19
  set_source_files_properties(${PROJECT_SOURCE_DIR}/lib/backend/netcdf.cpp PROPERTIES
                              COMPILE_DEFINITIONS TOLIMAN_NETCDF="${netcdf}")
  target_include_directories(toliman_objects SYSTEM PRIVATE ${NETCDF_INCLUDE})
endif()

set(toliman_isas baseline)
set(toliman_isa_flags_baseline "")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  list(APPEND toliman_isas avx2 avx512)
  set(toliman_isa_flags_avx2 -march=x86-64-v3)
  set(toliman_isa_flags_avx512 -march=x86-64-v4 -mprefer-vector-width=512)
endif()
set(toliman_isa_objects "")
foreach(isa IN LISTS toliman_isas)
  add_library(toliman_kernels_${isa} OBJECT ${isa_sources})
  target_link_libraries(toliman_kernels_${isa} PRIVATE toliman_settings)
  target_compile_definitions(toliman_kernels_${isa} PRIVATE TOLIMAN_ISA=${isa})
  # -fno-trapping-math and -fno-math-errno change no value; without them the loops do not vectorise.
  target_compile_options(toliman_kernels_${isa} PRIVATE -O3 -fno-math-errno -fno-trapping-math
                         ${toliman_isa_flags_${isa}} ${toliman_counted})
  if(TOLIMAN_SANITIZE MATCHES fuzzer-no-link) # kernels parse nothing, and counting their loops would take most of the time
    target_compile_options(toliman_kernels_${isa} PRIVATE -fno-sanitize=fuzzer-no-link)
  endif()
  list(APPEND toliman_isa_objects $<TARGET_OBJECTS:toliman_kernels_${isa}>)
endforeach()
# Kernels in float32 whose bits are not promised across instruction sets: fused multiply-adds are allowed.
set_source_files_properties(${PROJECT_SOURCE_DIR}/lib/kernels/conv.isa.cpp
                            ${PROJECT_SOURCE_DIR}/lib/kernels/elu.isa.cpp
                            ${PROJECT_SOURCE_DIR}/lib/kernels/same_conv.isa.cpp PROPERTIES COMPILE_OPTIONS -ffp-contract=fast)

set(toliman_includes $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
                     $<INSTALL_INTERFACE:include>)
add_library(toliman SHARED $<TARGET_OBJECTS:toliman_objects> ${toliman_isa_objects})
target_link_libraries(toliman PRIVATE ${toliman_needs})
target_link_options(toliman PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/lib/api/toliman.sym)
if(NOT TOLIMAN_SANITIZE) # clang's sanitizer runtime is in the program only
  target_link_options(toliman PRIVATE -Wl,-z,defs)
endif()
set_target_properties(toliman PROPERTIES VERSION 0.${PROJECT_VERSION_MINOR} SOVERSION 0.${PROJECT_VERSION_MINOR}
                      LINK_DEPENDS ${PROJECT_SOURCE_DIR}/lib/api/toliman.sym)
target_include_directories(toliman INTERFACE ${toliman_includes})

# The static library is one object in which only toliman_* is global, so that no other name conflicts with one of the
# host's; --gc-sections removes unused functions. Sanitizers and coverage counters need the separate objects.
set(toliman_static_objects $<FILTER:$<TARGET_OBJECTS:toliman_objects>,EXCLUDE,ch$> ${toliman_isa_objects})
if(NOT TOLIMAN_SANITIZE AND NOT TOLIMAN_COVERAGE)
  set(linker ${CMAKE_LINKER})
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang) # CMake takes its lld, which has no --force-group-allocation
    find_program(BINUTILS_LD ld REQUIRED)
    set(linker ${BINUTILS_LD})
  endif()
  set(whole ${PROJECT_BINARY_DIR}/toliman_whole.o)
  set(toliman_static_object ${PROJECT_BINARY_DIR}/toliman.o)
  add_custom_command(
    OUTPUT ${toliman_static_object}
    COMMAND ${linker} -r --force-group-allocation -o ${whole} ${toliman_static_objects}
    COMMAND ${CMAKE_OBJCOPY} --wildcard --keep-global-symbol=toliman_* ${whole} ${toliman_static_object}
    DEPENDS ${toliman_static_objects}
    BYPRODUCTS ${whole}
    COMMAND_EXPAND_LISTS VERBATIM)
  set(toliman_static_objects ${toliman_static_object})
endif()
add_library(toliman_static STATIC ${toliman_static_objects})
set_target_properties(toliman_static PROPERTIES LINKER_LANGUAGE CXX)
target_link_libraries(toliman_static PRIVATE ${toliman_needs})
target_include_directories(toliman_static INTERFACE ${toliman_includes})
set_target_properties(toliman_static PROPERTIES OUTPUT_NAME toliman)
