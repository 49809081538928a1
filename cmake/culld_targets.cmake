# One target per room: a link that the dependency rule forbids fails here as well as in tests/check_layers.py.

add_library(culld_flags INTERFACE)
target_compile_features(culld_flags INTERFACE cxx_std_20)
target_include_directories(culld_flags INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_compile_options(culld_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wnon-virtual-dtor -Wold-style-cast
  # Highway 1.0.3 with g++ 12.2 needs this baseline to generate SSE4, AVX2 and AVX3 (docs/adr/0001).
  -march=x86-64-v2 -maes -mpclmul
  # Same bytes on every SIMD target: no silent fused multiply-add (docs/error-model.md).
  -ffp-contract=off -fno-fast-math)
# g++ 12 sees uninitialized members in moved std::variants and overlapping copies in std::string sums, where
# there are none; clang and the sanitizers watch over both.
target_compile_options(culld_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-restrict>)
if(CULLD_SANITIZE)
  target_compile_options(culld_flags INTERFACE -fsanitize=${CULLD_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(culld_flags INTERFACE -fsanitize=${CULLD_SANITIZE})
  target_compile_definitions(culld_flags INTERFACE CULLD_SANITIZED)  # tests/scenes/rounds.h
else()  # instrumented code makes g++ 12 warn where there is nothing to warn of
  target_compile_options(culld_flags INTERFACE -Werror)
endif()
if(CULLD_FUZZ)  # the rooms tell libFuzzer which of their branches ran
  target_compile_options(culld_flags INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(culld_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# culld_room(NAME SOURCES a.cpp ... DEPS culld_core ... SYSTEM hwy::hwy ...)
# BUILD_INTERFACE: who links an installed room gets neither our warnings nor our libraries' packages.
function(culld_room name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;SYSTEM" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  list(TRANSFORM ARG_SYSTEM REPLACE "(.+)" "$<BUILD_INTERFACE:\\1>")
  target_link_libraries(${name} PUBLIC $<BUILD_INTERFACE:culld_flags> ${ARG_DEPS} PRIVATE ${ARG_SYSTEM})
endfunction()

# culld_program(NAME SOURCES main.cpp ... DEPS ... SYSTEM ...): a binary in bin/.
function(culld_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;SYSTEM" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE culld_flags ${ARG_DEPS} ${ARG_SYSTEM})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()

# Adds `target` to build_<room>, so that a script builds one room's tests (tests/unit/scene -> build_scene).
function(culld_add_to_room target room)
  if(NOT TARGET build_${room})
    add_custom_target(build_${room})
  endif()
  add_dependencies(build_${room} ${target})
endfunction()

# culld_test(NAME SOURCES x_test.cpp ... DEPS ... [LABELS ...] [TIMEOUT s]): one GoogleTest binary, one ctest.
# Its folder's name is a label too. The label `timing` is for tests that measure: they run alone.
function(culld_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPS;SYSTEM;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  if(CULLD_SANITIZE)  # ten times slower, and built beside others
    math(EXPR ARG_TIMEOUT "${ARG_TIMEOUT} * 4")
  endif()
  get_filename_component(room ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE culld_flags ${ARG_DEPS} ${ARG_SYSTEM} GTest::gtest GTest::gtest_main)
  culld_add_to_room(${name} ${room})
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${room};${ARG_LABELS}")
  if("timing" IN_LIST ARG_LABELS)
    set_tests_properties(${name} PROPERTIES RUN_SERIAL ON)
  endif()
endfunction()

# culld_gpu_test(NAME SOURCES ... DEPS ... [TIMEOUT s]): a program run once for each way to a context; EGL
# and OSMesa do not go together in one process. Skipped, and listed so, where a library is not installed.
function(culld_gpu_test name)
  culld_test(${name} ${ARGN})
  target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/unit/gpu/main.cpp)
  set_tests_properties(${name} PROPERTIES ENVIRONMENT CULLD_TEST_BACKEND=egl-surfaceless SKIP_RETURN_CODE 77)
  get_test_property(${name} TIMEOUT timeout)
  get_test_property(${name} LABELS labels)
  add_test(NAME ${name}_osmesa COMMAND ${name})
  # OSMesa keeps memory until the process ends, in places where LeakSanitizer's tracer itself crashes now and then.
  set_tests_properties(${name}_osmesa PROPERTIES
    ENVIRONMENT "CULLD_TEST_BACKEND=osmesa;ASAN_OPTIONS=detect_leaks=0" SKIP_RETURN_CODE 77
    TIMEOUT ${timeout} LABELS "${labels}")
endfunction()

# culld_fuzz(NAME SOURCES ... DEPS ...): libFuzzer in the preset fuzz; elsewhere a replay of the corpus as a ctest.
function(culld_fuzz name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;SYSTEM" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE culld_flags ${ARG_DEPS} ${ARG_SYSTEM})
  culld_add_to_room(${name} fuzz)
  set(corpus ${PROJECT_SOURCE_DIR}/tests/fuzz/corpus/${name})
  if(CULLD_FUZZ)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer)
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin/fuzz)
  else()
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/fuzz/replay_main.cpp)
    add_test(NAME ${name}_replay COMMAND ${name} ${corpus})
    set_tests_properties(${name}_replay PROPERTIES LABELS "fuzz" TIMEOUT 300)
  endif()
endfunction()
