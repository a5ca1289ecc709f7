# make install: one prefix, which may be moved afterwards. The components are the Debian packages of package.cmake.
include(CMakePackageConfigHelpers)

install(TARGETS toliman EXPORT toliman-shared
        LIBRARY DESTINATION lib COMPONENT runtime NAMELINK_COMPONENT development)
install(TARGETS toliman_static EXPORT toliman-static ARCHIVE DESTINATION lib COMPONENT development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/toliman DESTINATION include COMPONENT development
        FILES_MATCHING PATTERN *.h PATTERN *.hpp)
install(FILES ${PROJECT_BINARY_DIR}/include/toliman/version.h DESTINATION include/toliman COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/fortran/toliman.f90 DESTINATION share/toliman/fortran COMPONENT development)
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/man/man3 DESTINATION share/man COMPONENT development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tools/docs/ DESTINATION share/doc/toliman COMPONENT development
        FILES_MATCHING PATTERN *.md PATTERN README.md EXCLUDE)

# pkg-config and find_package, with paths relative to their own files.
configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/toliman.pc.in ${PROJECT_BINARY_DIR}/toliman.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/toliman.pc DESTINATION lib/pkgconfig COMPONENT development)
set(package lib/cmake/toliman)
install(EXPORT toliman-shared NAMESPACE toliman:: DESTINATION ${package} COMPONENT development)
install(EXPORT toliman-static NAMESPACE toliman:: DESTINATION ${package} COMPONENT development)
configure_package_config_file(${PROJECT_SOURCE_DIR}/tools/cmake/toliman-config.cmake.in
                              ${PROJECT_BINARY_DIR}/toliman-config.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/toliman-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/toliman-config.cmake ${PROJECT_BINARY_DIR}/toliman-config-version.cmake
        DESTINATION ${package} COMPONENT development)

install(TARGETS toliman_cli RUNTIME DESTINATION bin COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/scenes DESTINATION share/toliman COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tools/schema DESTINATION share/toliman COMPONENT program
        FILES_MATCHING PATTERN *.json)
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/bash-completion ${PROJECT_BINARY_DIR}/share/zsh
        ${PROJECT_BINARY_DIR}/share/fish DESTINATION share COMPONENT program)
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/man/man1 DESTINATION share/man COMPONENT program
        PATTERN toliman-mpi.1.gz EXCLUDE)
if(TARGET toliman_mpi)
  install(TARGETS toliman_mpi RUNTIME DESTINATION bin COMPONENT mpi)
  install(FILES ${PROJECT_BINARY_DIR}/share/man/man1/toliman-mpi.1.gz DESTINATION share/man/man1 COMPONENT mpi)
endif()

# Debian's Python searches this folder below /usr; for other prefixes PYTHONPATH must name it.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/bindings/python/toliman DESTINATION lib/python3/dist-packages COMPONENT python
        FILES_MATCHING PATTERN *.py PATTERN page.html PATTERN py.typed PATTERN __pycache__ EXCLUDE)
set(python ${PROJECT_BINARY_DIR}/python/toliman)
install(FILES ${python}/_raw.py ${python}/_results.py DESTINATION lib/python3/dist-packages/toliman COMPONENT python)
install(FILES ${python}/report/_network.py DESTINATION lib/python3/dist-packages/toliman/report COMPONENT python)
# Metadata for pip and importlib.metadata.
file(WRITE ${PROJECT_BINARY_DIR}/dist-info/METADATA
     "Metadata-Version: 2.1\nName: toliman\nVersion: ${PROJECT_VERSION}\nSummary: ${PROJECT_DESCRIPTION}\n"
     "Requires-Python: >=3.9\nRequires-Dist: numpy (>=1.20)\n"
     "Provides-Extra: report\nRequires-Dist: matplotlib (>=3.6); extra == 'report'\n"
     "Requires-Dist: jinja2 (>=3.0); extra == 'report'\n")
install(FILES ${PROJECT_BINARY_DIR}/dist-info/METADATA COMPONENT python
        DESTINATION lib/python3/dist-packages/toliman-${PROJECT_VERSION}.dist-info)
