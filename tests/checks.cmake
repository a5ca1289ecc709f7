# The project's checks as tests, and tests of the checks themselves.
set(check ${PROJECT_SOURCE_DIR}/tools/check)

add_test(NAME check/layers COMMAND ${check}/layers)
add_test(NAME check/words COMMAND ${check}/words)
add_test(NAME check/shape COMMAND ${check}/shape)
add_test(NAME check/promises COMMAND ${check}/promises)
add_test(NAME check/format COMMAND ${check}/format)
add_test(NAME check/headers COMMAND ${check}/headers ${PROJECT_BINARY_DIR}/include)
add_test(NAME check/bindings COMMAND ${check}/bindings)
add_test(NAME check/types COMMAND mypy --python-version 3.9 --ignore-missing-imports
                                  --cache-dir ${PROJECT_BINARY_DIR}/mypy ${PROJECT_BINARY_DIR}/python/toliman
                                  ${CMAKE_CURRENT_SOURCE_DIR}/bind/typed_program.py)
add_test(NAME check/exports COMMAND ${check}/exports $<TARGET_FILE:toliman>)
add_test(NAME check/abi COMMAND ${check}/abi)

foreach(isa IN LISTS toliman_isas)
  if(NOT isa STREQUAL baseline)
    add_test(NAME check/isa_${isa} COMMAND ${check}/isa $<TARGET_OBJECTS:toliman_kernels_${isa}> COMMAND_EXPAND_LISTS)
  endif()
endforeach()

add_test(NAME header/checks COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_checks.py)
add_test(NAME header/bindings COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_bindings.py)
add_test(NAME header/docs COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_docs.py)
add_test(NAME header/shape COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_shape.py)
add_test(NAME header/promises COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_promises.py)
add_test(NAME header/units COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_units.py)
add_test(NAME header/workflows COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_workflows.py)
add_test(NAME header/types COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_types.py)
add_test(NAME abi/exports COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/abi/test_exports.py)
add_test(NAME abi/interface COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/abi/test_interface.py)
add_test(NAME install/deps COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_deps.py)
add_test(NAME install/copied_tree COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_copied_tree.py)
add_test(NAME install/installed COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_installed.py)
set_tests_properties(install/installed PROPERTIES ENVIRONMENT TOLIMAN_BUILD=${PROJECT_BINARY_DIR})
add_test(NAME install/pip COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_pip.py)
add_test(NAME install/wheel COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_wheel.py)
set_tests_properties(install/pip install/wheel PROPERTIES ENVIRONMENT
                     "TOLIMAN_LIBRARY=$<TARGET_FILE:toliman>;TOLIMAN_BUILD=${PROJECT_BINARY_DIR}")
set_tests_properties(check/format header/checks PROPERTIES SKIP_RETURN_CODE 77)
add_test(NAME install/readme COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_readme.py)
set_tests_properties(install/readme PROPERTIES ENVIRONMENT TOLIMAN_BUILD=${PROJECT_BINARY_DIR})
add_test(NAME install/manual COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_manual.py)
set_tests_properties(install/manual PROPERTIES ENVIRONMENT TOLIMAN_BUILD=${PROJECT_BINARY_DIR})
add_test(NAME install/package COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_package.py)
set_tests_properties(install/package PROPERTIES ENVIRONMENT TOLIMAN_BUILD=${PROJECT_BINARY_DIR})

# The tests of the checks, the man pages, and what needs the installation that install/installed tests.
set_tests_properties(header/checks header/bindings abi/interface install/manual install/package install/pip install/wheel
                     PROPERTIES LABELS long)

# A call of every public function: while memory allocations or file calls fail, from two threads at once, and in a host
# program that watches which functions the library calls, with a library that violates the conventions to test the watch
# itself. Not with sanitizers, which replace the same functions.
if(NOT TOLIMAN_SANITIZE)
  set(scenarios ${PROJECT_BINARY_DIR}/generated/fault/scenarios.c)
  add_custom_command(
    OUTPUT ${scenarios}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/generated/fault
    COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/gen/scenarios ${scenarios}
    DEPENDS ${toliman_generators} ${PROJECT_SOURCE_DIR}/tools/gen/scenarios ${PROJECT_SOURCE_DIR}/tools/gen/shapes
            ${CMAKE_CURRENT_SOURCE_DIR}/fault/scenarios ${PROJECT_SOURCE_DIR}/CMakeLists.txt
    VERBATIM)
  add_library(toliman_scenarios OBJECT ${scenarios} fault/attempts.c fault/files.c fault/scenes.c fault/series.c
                                       fault/trackers.c)
  target_include_directories(toliman_scenarios PUBLIC fault)
  target_link_libraries(toliman_scenarios PUBLIC toliman PkgConfig::CMOCKA Threads::Threads m)
  add_executable(faults fault/faults.c fault/failing.c)
  target_compile_options(faults PRIVATE -fno-builtin)
  add_library(toliman_violations SHARED abi/violations.c)
  target_compile_options(toliman_violations PRIVATE -fno-optimize-sibling-calls)
  target_link_libraries(toliman_violations PRIVATE PkgConfig::TOLIMAN_NEEDS)
  add_executable(conventions abi/conventions.c abi/watch.c)
  target_link_libraries(conventions PRIVATE toliman_violations PkgConfig::TOLIMAN_NEEDS dl)
  foreach(target IN ITEMS faults conventions)
    set_target_properties(${target} PROPERTIES ENABLE_EXPORTS ON)
    target_link_libraries(${target} PRIVATE toliman_scenarios)
  endforeach()
  add_executable(digests same/digests.c fault/failing.c kernel/shim_blas_core.cpp) # with the library's symbols inside
  target_compile_options(digests PRIVATE $<$<COMPILE_LANGUAGE:C>:-fno-builtin>)
  target_link_libraries(digests PRIVATE toliman_inside toliman_settings toliman_scenarios)
  set_target_properties(toliman_scenarios faults conventions digests PROPERTIES C_STANDARD 11)
  add_test(NAME same/digests COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/same/test_digests.py)
  set_tests_properties(same/digests PROPERTIES ENVIRONMENT TOLIMAN_DIGESTS=$<TARGET_FILE:digests>)
  add_test(NAME abi/conventions COMMAND ${DEBIAN_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/abi/test_conventions.py)
  set_tests_properties(abi/conventions PROPERTIES ENVIRONMENT
                       "TOLIMAN_CONVENTIONS=$<TARGET_FILE:conventions>;TOLIMAN_LIBRARY=$<TARGET_FILE:toliman>")
  foreach(what memory files threads)
    add_test(NAME fault/${what} COMMAND faults ${PROJECT_SOURCE_DIR}/lib/api/toliman.sym ${what})
    # Freed blocks are overwritten, so that reads after free are detected.
    set_tests_properties(fault/${what} PROPERTIES ENVIRONMENT GLIBC_TUNABLES=glibc.malloc.perturb=165)
  endforeach()
endif()
