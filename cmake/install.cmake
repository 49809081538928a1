# What `cmake --install` puts, in components of which each becomes a Debian package (cmake/package.cmake):
#   daemon  culld, its manual pages, completion, units of systemd and configuration
#   cli     cullctl, the same
#   lib     the client's shared library for C
#   sdk     the client SDK with a CMake package (culld-client) and pkg-config files, for C++ and for C
# The engine is not an API.

set(culld_sdk_include ${CMAKE_INSTALL_INCLUDEDIR}/culld-client)
set(culld_sdk_cmake ${CMAKE_INSTALL_LIBDIR}/cmake/culld-client)
set(culld_extras ${PROJECT_BINARY_DIR}/packaging)

# culld_install_extras(PROGRAM COMPONENT): what makes a program at home in a system.
function(culld_install_extras program component)
  install(FILES ${culld_extras}/${program}.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
  install(FILES ${culld_extras}/completion/bash/${program}
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions COMPONENT ${component})
  install(FILES ${culld_extras}/completion/zsh/_${program}
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/zsh/vendor-completions COMPONENT ${component})
endfunction()

install(TARGETS culld RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT daemon)
culld_install_extras(culld daemon)
install(FILES ${culld_extras}/culld.toml.5.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man5 COMPONENT daemon)
configure_file(packaging/install_system.cmake.in ${culld_extras}/install_system.cmake @ONLY)
install(SCRIPT ${culld_extras}/install_system.cmake COMPONENT daemon)

install(TARGETS cullctl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT cli)
culld_install_extras(cullctl cli)

foreach(library culld_client culld_protocol)
  target_compile_features(${library} PUBLIC cxx_std_20)
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${culld_sdk_include}>)
endforeach()
set_target_properties(culld_client PROPERTIES EXPORT_NAME client)
set_target_properties(culld_protocol PROPERTIES EXPORT_NAME protocol)

install(TARGETS culld_client culld_protocol EXPORT culld-client
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
install(TARGETS culld_client_c EXPORT culld-client
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT lib NAMELINK_COMPONENT sdk)
target_include_directories(culld_client_c INTERFACE $<INSTALL_INTERFACE:${culld_sdk_include}>)
install(DIRECTORY client/sdk/include/ DESTINATION ${culld_sdk_include} COMPONENT sdk FILES_MATCHING PATTERN "*.h")
# Of protocol, what the SDK's headers speak of.
install(FILES protocol/answer_file.h protocol/limits.h protocol/messages.h protocol/result.h DESTINATION ${culld_sdk_include}/protocol COMPONENT sdk)
install(EXPORT culld-client NAMESPACE culld:: FILE culld-clientTargets.cmake DESTINATION ${culld_sdk_cmake} COMPONENT sdk)

include(CMakePackageConfigHelpers)
configure_package_config_file(cmake/culld-clientConfig.cmake.in ${PROJECT_BINARY_DIR}/culld-clientConfig.cmake
  INSTALL_DESTINATION ${culld_sdk_cmake})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/culld-clientConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/culld-clientConfig.cmake ${PROJECT_BINARY_DIR}/culld-clientConfigVersion.cmake
  DESTINATION ${culld_sdk_cmake} COMPONENT sdk)

foreach(pc culld-client culld-client-c)
  configure_file(cmake/${pc}.pc.in ${PROJECT_BINARY_DIR}/${pc}.pc @ONLY)
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/culld-client.pc ${PROJECT_BINARY_DIR}/culld-client-c.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT sdk)
