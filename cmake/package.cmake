# Debian packages of the installed components: `cpack --config build/release/CPackConfig.cmake -B OUT`.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME culld)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL daemon cli lib sdk)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# culld_package(COMPONENT NAME SECTION SUMMARY LINES...): and the files that every Debian package has.
macro(culld_package component name section)
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${section})
  string(REPLACE ";" "\n" CPACK_DEBIAN_${key}_DESCRIPTION "${ARGN}")
  install(FILES packaging/debian/copyright ${PROJECT_BINARY_DIR}/packaging/changelog.Debian.gz
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${name} COMPONENT ${component} EXCLUDE_FROM_ALL)
endmacro()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own

culld_package(daemon culld net
  "visibility server: which objects can a camera see?"
  "culld holds glTF scenes. A client sends a camera and gets back the objects"
  "that this camera can see. An object is left out only with a proof that it"
  "cannot be seen.")
culld_package(cli cullctl net
  "command line client of the visibility server culld"
  "cullctl uploads and describes scenes, sends cameras to a server and writes"
  "what it answers.")
culld_package(lib libculld-client1 libs
  "client library of the visibility server culld, for C"
  "A shared library for programs that ask culld which objects a camera can see.")
culld_package(sdk libculld-client-dev libdevel
  "client SDK of the visibility server culld"
  "Headers and libraries for programs that ask culld which objects a camera can"
  "see, with a CMake package and a pkg-config file.")
set(CPACK_DEBIAN_DAEMON_PACKAGE_RECOMMENDS cullctl)
set(CPACK_DEBIAN_DAEMON_PACKAGE_SUGGESTS "libegl1, libgl1-mesa-dri, libosmesa6")  # opened at run time, if at all
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(culld_control conffiles postinst prerm postrm)
list(TRANSFORM culld_control PREPEND ${PROJECT_SOURCE_DIR}/packaging/debian/)
set(CPACK_DEBIAN_DAEMON_PACKAGE_CONTROL_EXTRA ${culld_control})
set(CPACK_DEBIAN_SDK_PACKAGE_DEPENDS "libculld-client1 (= ${PROJECT_VERSION}-1), libssl-dev")  # the static libraries are linked against it
include(CPack)
