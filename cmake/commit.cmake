# Writes OUT, a header that names the commit being built; run at every build, so that it is never
# that of an earlier configuration. usage: cmake -DSOURCE=DIR -DOUT=FILE -P commit.cmake
execute_process(COMMAND git describe --always --dirty --abbrev=12
  WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
if(NOT commit)
  set(commit unknown)
endif()
set(text "#pragma once\nnamespace culld { inline constexpr const char* kCommit = \"${commit}\"; }\n")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE ${OUT} "${text}")
endif()
