# What `cmake --install` puts: the daemon, the command line client, and the client SDK with a CMake
# package (culld-client) and a pkg-config file. The engine is not an API.

set(culld_sdk_include ${CMAKE_INSTALL_INCLUDEDIR}/culld-client)
set(culld_sdk_cmake ${CMAKE_INSTALL_LIBDIR}/cmake/culld-client)

foreach(library culld_client culld_protocol)
  target_compile_features(${library} PUBLIC cxx_std_20)
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${culld_sdk_include}>)
endforeach()
set_target_properties(culld_client PROPERTIES EXPORT_NAME client)
set_target_properties(culld_protocol PROPERTIES EXPORT_NAME protocol)

install(TARGETS culld cullctl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS culld_client culld_protocol EXPORT culld-client ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY client/sdk/include/ DESTINATION ${culld_sdk_include} FILES_MATCHING PATTERN "*.h")
install(DIRECTORY protocol DESTINATION ${culld_sdk_include} FILES_MATCHING PATTERN "*.h" PATTERN schema EXCLUDE)
install(EXPORT culld-client NAMESPACE culld:: FILE culld-clientTargets.cmake DESTINATION ${culld_sdk_cmake})

include(CMakePackageConfigHelpers)
configure_package_config_file(cmake/culld-clientConfig.cmake.in ${PROJECT_BINARY_DIR}/culld-clientConfig.cmake
  INSTALL_DESTINATION ${culld_sdk_cmake})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/culld-clientConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/culld-clientConfig.cmake ${PROJECT_BINARY_DIR}/culld-clientConfigVersion.cmake
  DESTINATION ${culld_sdk_cmake})

configure_file(cmake/culld-client.pc.in ${PROJECT_BINARY_DIR}/culld-client.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/culld-client.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
