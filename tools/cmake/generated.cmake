# What tools/gen makes from the public headers: the Fortran source, modules of the Python package, sizes of structs,
# rules of options.
# ${PROJECT_BINARY_DIR}/python is the complete Python package: these modules, and links to the files of bindings/python.
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)

set(package ${PROJECT_BINARY_DIR}/python)
set(toliman_generated ${PROJECT_BINARY_DIR}/fortran/toliman.f90 ${PROJECT_BINARY_DIR}/generated/api/struct_sizes.hpp
    ${PROJECT_BINARY_DIR}/generated/api/option_rules.hpp
    ${package}/toliman/_raw.py ${package}/toliman/_results.py ${package}/toliman/report/_network.py)
file(GLOB toliman_generators CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/toliman/*.h
     ${PROJECT_SOURCE_DIR}/include/toliman/*.h.in ${PROJECT_SOURCE_DIR}/tools/gen/*.py)
add_custom_command(
  OUTPUT ${toliman_generated}
  COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/gen/generate ${PROJECT_BINARY_DIR}
  DEPENDS ${toliman_generators} ${PROJECT_SOURCE_DIR}/tools/gen/generate ${PROJECT_SOURCE_DIR}/tools/gen/shapes
          ${PROJECT_SOURCE_DIR}/tools/gen/toliman.f90.in ${PROJECT_SOURCE_DIR}/lib/cae/layout.hpp
          ${PROJECT_SOURCE_DIR}/CMakeLists.txt
  COMMENT "Generating the bindings"
  VERBATIM)
add_custom_target(toliman_generated ALL DEPENDS ${toliman_generated})

# Links, so that an edit takes effect without a build. Those to files that are gone would hide that they are gone.
file(GLOB_RECURSE links ${package}/*)
foreach(link IN LISTS links)
  if(IS_SYMLINK ${link} AND NOT EXISTS ${link})
    file(REMOVE ${link})
  endif()
endforeach()
set(sources ${PROJECT_SOURCE_DIR}/bindings/python)
file(GLOB_RECURSE files CONFIGURE_DEPENDS RELATIVE ${sources} ${sources}/*.py ${sources}/*.toml ${sources}/*.html
     ${sources}/py.typed)
foreach(name IN LISTS files)
  get_filename_component(folder ${package}/${name} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  file(CREATE_LINK ${sources}/${name} ${package}/${name} SYMBOLIC)
endforeach()
