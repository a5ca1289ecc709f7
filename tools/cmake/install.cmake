# make install: program, both libraries, headers, pkg-config file and man page below one prefix that may be moved.
install(TARGETS toliman toliman_static toliman_cli RUNTIME DESTINATION bin LIBRARY DESTINATION lib
        ARCHIVE DESTINATION lib)
if(TARGET toliman_mpi)
  install(TARGETS toliman_mpi RUNTIME DESTINATION bin)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/toliman DESTINATION include FILES_MATCHING PATTERN *.h PATTERN *.hpp)
install(FILES ${PROJECT_BINARY_DIR}/include/toliman/version.h DESTINATION include/toliman)
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/man ${PROJECT_BINARY_DIR}/share/bash-completion DESTINATION share)
configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/toliman.pc.in ${PROJECT_BINARY_DIR}/toliman.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/toliman.pc DESTINATION lib/pkgconfig)
