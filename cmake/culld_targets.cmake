# One target per room: a link that the dependency rule forbids fails here as well as in tests/check_layers.py.

add_library(culld_flags INTERFACE)
target_compile_features(culld_flags INTERFACE cxx_std_20)
target_include_directories(culld_flags INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_compile_options(culld_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wnon-virtual-dtor -Wold-style-cast -Werror
  # Highway 1.0.3 with g++ 12.2 needs this baseline to generate SSE4, AVX2 and AVX3 (docs/adr/0001).
  -march=x86-64-v2 -maes -mpclmul
  # Same bytes on every SIMD target: no silent fused multiply-add (docs/error-model.md).
  -ffp-contract=off -fno-fast-math)
if(CULLD_SANITIZE)
  target_compile_options(culld_flags INTERFACE -fsanitize=${CULLD_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(culld_flags INTERFACE -fsanitize=${CULLD_SANITIZE})
endif()

# culld_room(NAME SOURCES a.cpp ... DEPS culld_core ... SYSTEM hwy::hwy ...)
function(culld_room name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;SYSTEM" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC culld_flags ${ARG_DEPS} PRIVATE ${ARG_SYSTEM})
endfunction()

# culld_program(NAME SOURCES main.cpp ... DEPS ... SYSTEM ...): a binary in bin/.
function(culld_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;SYSTEM" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE culld_flags ${ARG_DEPS} ${ARG_SYSTEM})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()

# culld_test(NAME SOURCES x_test.cpp ... DEPS ... [LABELS ...] [TIMEOUT s]): one GoogleTest binary, one ctest.
function(culld_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPS;SYSTEM;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE culld_flags ${ARG_DEPS} ${ARG_SYSTEM} GTest::gtest GTest::gtest_main)
  target_precompile_headers(${name} PRIVATE <gtest/gtest.h>)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}")
endfunction()

# culld_fuzz(NAME SOURCES ... DEPS ...): libFuzzer in the preset fuzz; elsewhere a replay of the corpus as a ctest.
function(culld_fuzz name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;SYSTEM" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE culld_flags ${ARG_DEPS} ${ARG_SYSTEM})
  set(corpus ${PROJECT_SOURCE_DIR}/tests/fuzz/corpus/${name})
  if(CULLD_FUZZ)
    target_compile_options(${name} PRIVATE -fsanitize=fuzzer)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer)
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  else()
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/fuzz/replay_main.cpp)
    add_test(NAME ${name}_replay COMMAND ${name} ${corpus})
    set_tests_properties(${name}_replay PROPERTIES LABELS "fuzz" TIMEOUT 300)
  endif()
endfunction()
