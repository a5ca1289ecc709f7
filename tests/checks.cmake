# The house rules as tests, and the proof that each check finds what it is there for.
find_program(PYTHON3 python3 REQUIRED)
set(check ${PROJECT_SOURCE_DIR}/tools/check)

add_test(NAME check/layers COMMAND ${check}/layers)
add_test(NAME check/words COMMAND ${check}/words)
add_test(NAME check/format COMMAND ${check}/format)
add_test(NAME check/headers COMMAND ${check}/headers ${PROJECT_BINARY_DIR}/include)
add_test(NAME check/exports COMMAND ${check}/exports $<TARGET_FILE:toliman>)
foreach(isa IN LISTS toliman_isas)
  if(NOT isa STREQUAL baseline)
    add_test(NAME check/isa_${isa} COMMAND ${check}/isa $<TARGET_OBJECTS:toliman_kernels_${isa}> COMMAND_EXPAND_LISTS)
  endif()
endforeach()

add_test(NAME header/checks COMMAND ${PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/header/test_checks.py)
add_test(NAME abi/exports COMMAND ${PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/abi/test_exports.py)
add_test(NAME install/deps COMMAND ${PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/install/test_deps.py)
set_tests_properties(check/format header/checks PROPERTIES SKIP_RETURN_CODE 77)
