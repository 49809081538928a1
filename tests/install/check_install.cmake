# Installs into a folder of its own, moves that elsewhere, and builds a consumer against it: with
# CMake, and with pkg-config. cmake -DBUILD=... -DSOURCE=... -DWORK=... -DCXX=... -P check_install.cmake
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/moved)
run(${WORK}/moved/bin/culld --version)
run(${WORK}/moved/bin/cullctl --version)

run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${WORK}/consumer -G Ninja
  -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_PREFIX_PATH=${WORK}/moved)
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/consumer)

# Every installed header stands alone, with what was installed and the standard library.
file(GLOB_RECURSE headers RELATIVE ${WORK}/moved/include/culld-client ${WORK}/moved/include/culld-client/*.h)
foreach(header ${headers})
  file(WRITE ${WORK}/alone.cpp "#include \"${header}\"\n")
  run(${CXX} -std=c++20 -Wall -Wextra -Werror -fsyntax-only -I${WORK}/moved/include/culld-client ${WORK}/alone.cpp)
endforeach()

file(GLOB_RECURSE pc ${WORK}/moved/*culld-client.pc)
cmake_path(GET pc PARENT_PATH pc_folder)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
execute_process(COMMAND pkg-config --define-prefix --cflags --libs culld-client
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${CXX} ${SOURCE}/tests/install/consumer.cpp -o ${WORK}/pkg_config_consumer ${flags})
run(${WORK}/pkg_config_consumer)
