# make install: program, both libraries, headers, pkg-config file and man page below one prefix that may be moved.
install(TARGETS toliman toliman_static toliman_cli RUNTIME DESTINATION bin LIBRARY DESTINATION lib
        ARCHIVE DESTINATION lib)
if(TARGET toliman_mpi)
  install(TARGETS toliman_mpi RUNTIME DESTINATION bin)
  install(FILES ${PROJECT_SOURCE_DIR}/tools/man/toliman-mpi.1 DESTINATION share/man/man1)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/toliman DESTINATION include FILES_MATCHING PATTERN *.h PATTERN *.hpp)
install(FILES ${PROJECT_BINARY_DIR}/include/toliman/version.h DESTINATION include/toliman)
install(FILES ${PROJECT_SOURCE_DIR}/tools/man/toliman.1 DESTINATION share/man/man1)
configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/toliman.pc.in ${PROJECT_BINARY_DIR}/toliman.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/toliman.pc DESTINATION lib/pkgconfig)
