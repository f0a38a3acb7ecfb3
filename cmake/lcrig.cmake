# Compiler flags and small functions for every folder.

set(LCRIG_SANITIZE "" CACHE STRING "address (ASan+UBSan), thread, or empty")
option(LCRIG_WERROR "Warnings are errors" ON)

add_library(lcrig_flags INTERFACE)
target_compile_options(lcrig_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 inlines Asio's operator new of a coroutine frame but not its delete, and then warns.
  target_compile_options(lcrig_flags INTERFACE -Wno-mismatched-new-delete)
endif()
if(LCRIG_WERROR)
  target_compile_options(lcrig_flags INTERFACE -Werror)
endif()
target_include_directories(lcrig_flags INTERFACE ${CMAKE_SOURCE_DIR})
# No program knows where it was built, and two trees can share a compiler cache.
target_compile_options(lcrig_flags INTERFACE -ffile-prefix-map=${CMAKE_SOURCE_DIR}/=)
# Asio: one thread runs each io_context; no Boost library is linked.
target_compile_definitions(lcrig_flags INTERFACE BOOST_ASIO_NO_DEPRECATED
  LCRIG_VERSION="${PROJECT_VERSION}")
if(LCRIG_SANITIZE STREQUAL "address")
  # Pointer checks at every use would almost double the compile time of coroutines, and ASan finds
  # the same errors.
  target_compile_options(lcrig_flags INTERFACE -fsanitize=address,undefined
    -fno-sanitize=null,alignment,object-size,vptr -fno-sanitize-recover=all
    -fno-omit-frame-pointer)
  target_link_options(lcrig_flags INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(lcrig_flags INTERFACE _GLIBCXX_ASSERTIONS)
elseif(LCRIG_SANITIZE STREQUAL "thread")
  target_compile_options(lcrig_flags INTERFACE -fsanitize=thread)
  target_link_options(lcrig_flags INTERFACE -fsanitize=thread)
endif()

# The headers of Asio and JSON take longer to compile than our code, so several sources in one unit
# build in less than half the time. Turn it off while editing single files.
option(LCRIG_UNITY "Compile several sources as one unit" OFF)
set(LCRIG_UNITY_BATCH 32 CACHE STRING "Sources of a unit")
set(CMAKE_UNITY_BUILD_BATCH_SIZE ${LCRIG_UNITY_BATCH})
if(LCRIG_UNITY)
  set(CMAKE_UNITY_BUILD ON)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # In a unity build every source is an included file, which triggers this warning.
    target_compile_options(lcrig_flags INTERFACE -Wno-subobject-linkage)
  endif()
endif()

# Links the tests in less than half the processor time of the default linker.
find_program(LCRIG_LLD ld.lld)
if(LCRIG_LLD)
  add_link_options(-fuse-ld=lld)
endif()

# lcrig_library(name SOURCES ... LINK ...): a static library with the project's flags.
function(lcrig_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC lcrig_flags ${ARG_LINK})
endfunction()

# lcrig_program(name SOURCES ... LINK ...): an installed program.
function(lcrig_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE lcrig_flags ${ARG_LINK})
  install(TARGETS ${name})
endfunction()

# lcrig_test(name SOURCES ... LINK ... [LABEL word]): a GoogleTest program. Label `slow`: more time.
function(lcrig_test name)
  cmake_parse_arguments(ARG "" "LABEL" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE lcrig_flags ${ARG_LINK} GTest::gmock GTest::gtest_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  # Only a test that hangs may reach it, also where other programs keep the processors busy.
  set(properties PROPERTIES TIMEOUT 300)
  if(ARG_LABEL STREQUAL "slow")
    # Slow tests wait more than they compute, so they start first and run in parallel.
    list(APPEND properties COST 100)
  endif()
  if(LCRIG_SANITIZE OR CMAKE_BUILD_TYPE STREQUAL "Release")
    # Test code takes longer to compile than to run.
    target_compile_options(${name} PRIVATE -Og)
  endif()
  if(ARG_LABEL)
    list(APPEND properties LABELS ${ARG_LABEL})
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST ${properties}
    WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
endfunction()
