# make package: one Debian package per component of install.cmake, with the same files below /usr.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the libtoliman authors <libtoliman@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)

# The package of the shared library has the SONAME in its name, as Debian's policy requires; the others depend on exactly
# this version.
set(runtime libtoliman0.${PROJECT_VERSION_MINOR})
set(same "${runtime} (= ${PROJECT_VERSION})")

# component, package, section, dependencies, one line of description
function(toliman_package component package section depends description)
  string(TOUPPER ${component} part)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
  set(CPACK_DEBIAN_${part}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${part}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${part}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
  set(CPACK_COMPONENT_${part}_DESCRIPTION "${description}" PARENT_SCOPE)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/${package} RENAME copyright COMPONENT ${component}
          EXCLUDE_FROM_ALL)
endfunction()

set(CPACK_COMPONENTS_ALL "")
toliman_package(runtime ${runtime} libs "" "period of a planet from frames of the TOLIMAN space telescope, library")
toliman_package(development libtoliman-dev libdevel "${same}" "headers and static library of libtoliman, Fortran source")
toliman_package(program toliman science "${same}, libcfitsio10" "period of a planet from frames of the TOLIMAN space telescope")
toliman_package(python python3-toliman python "${same}, python3, python3-numpy" "libtoliman for Python 3")
# Debian's zsh searches this folder below /usr instead of site-functions.
install(FILES ${PROJECT_SOURCE_DIR}/tools/man/completion.zsh DESTINATION share/zsh/vendor-completions RENAME _toliman
        COMPONENT program EXCLUDE_FROM_ALL)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS # static
    "libfftw3-dev, libopenblas-dev, libcjson-dev, zlib1g-dev, liberfa-dev, libexpat1-dev")
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS toliman) # contains the scenes
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, python3-jinja2") # for toliman.report
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS libnetcdf19) # loaded for batches of frames
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# For `toliman report`.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "python3-toliman, python3-matplotlib, python3-jinja2")
if(TARGET toliman_mpi)
  toliman_package(mpi toliman-mpi science "${same}, libcfitsio10, openmpi-bin" "frames of the TOLIMAN space telescope on many machines")
  set(CPACK_DEBIAN_MPI_PACKAGE_SHLIBDEPS ON)
endif()
include(CPack)
