# Installs into a folder of its own, moves that elsewhere, and builds a consumer against it: with
# CMake, and with pkg-config. cmake -DBUILD=... -DSOURCE=... -DWORK=... -DCC=... -DCXX=... -P check_install.cmake
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/moved)
run(${WORK}/moved/bin/culld --version)
run(${WORK}/moved/bin/cullctl --version)

run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${WORK}/consumer -G Ninja
  -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_PREFIX_PATH=${WORK}/moved -DEXAMPLES=${SOURCE}/client/examples)
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/consumer)

# The shared library shows the C functions and nothing else, and is found under its SONAME.
file(GLOB_RECURSE shared ${WORK}/moved/*libculld-client.so.1)
execute_process(COMMAND nm -D --defined-only ${shared}
  OUTPUT_VARIABLE shown OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ";" shown "${shown}")
list(FILTER shown EXCLUDE REGEX " (T culld_[a-z_]+@@CULLD_CLIENT_1|A CULLD_CLIENT_1)$")
if(shown)
  message(FATAL_ERROR "${shared} shows ${shown}")
endif()
execute_process(COMMAND objdump -p ${shared} OUTPUT_VARIABLE head COMMAND_ERROR_IS_FATAL ANY)
if(NOT head MATCHES "SONAME +libculld-client.so.1\n")
  message(FATAL_ERROR "${shared}: not of the SONAME libculld-client.so.1")
endif()

# Every installed header stands alone, with what was installed and the standard library.
file(GLOB_RECURSE headers RELATIVE ${WORK}/moved/include/culld-client ${WORK}/moved/include/culld-client/*.h)
foreach(header ${headers})
  file(WRITE ${WORK}/alone.cpp "#include \"${header}\"\n")
  run(${CXX} -std=c++20 -Wall -Wextra -Werror -fsyntax-only -I${WORK}/moved/include/culld-client ${WORK}/alone.cpp)
endforeach()

file(GLOB_RECURSE pc ${WORK}/moved/*culld-client.pc)
cmake_path(GET pc PARENT_PATH pc_folder)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
set(examples ${WORK}/consumer/fly_c ${WORK}/consumer/fly_cpp)
execute_process(COMMAND pkg-config --define-prefix --cflags --libs culld-client-c
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
cmake_path(GET shared PARENT_PATH shared_folder)
run(${CC} -std=c11 -Wall -Wextra -Werror ${SOURCE}/client/examples/fly.c -o ${WORK}/pkg_config_fly ${flags} -Wl,-rpath,${shared_folder})
list(APPEND examples ${WORK}/pkg_config_fly)
run(${SOURCE}/tests/install/run_examples.sh ${BUILD}/bin ${examples})
execute_process(COMMAND pkg-config --define-prefix --cflags --libs culld-client
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${CXX} ${SOURCE}/tests/install/consumer.cpp -o ${WORK}/pkg_config_consumer ${flags})
run(${WORK}/pkg_config_consumer)
