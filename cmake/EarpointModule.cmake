# Flags that every target of the project shares.
add_library(earpoint_flags INTERFACE)
target_compile_features(earpoint_flags INTERFACE cxx_std_20)
target_compile_options(earpoint_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wold-style-cast
  -Wnon-virtual-dtor -Woverloaded-virtual)
# Sums in a fixed order, so that the same seed gives the same bytes: no -ffast-math anywhere.
target_compile_options(earpoint_flags INTERFACE -ffp-contract=off)
# GCC 12 gives false warnings about std::string's own copies (GCC bug 105651) in optimised builds.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(earpoint_flags INTERFACE -Wno-restrict)
endif()
# EARPOINT_CHECK(!"what is wrong") is intended.
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  target_compile_options(earpoint_flags INTERFACE -Wno-string-conversion)
endif()
# In precompiled headers GCC does not know which are the system's, and warns of those too.
if(EARPOINT_PRECOMPILE)
  target_compile_options(earpoint_flags INTERFACE -w)
endif()
if(EARPOINT_DCHECK)
  target_compile_definitions(earpoint_flags INTERFACE EARPOINT_DCHECK_ENABLED=1)
endif()
if(EARPOINT_FUZZ)
  # Counts the branches taken, in every module, for the fuzzer to aim at new ones.
  target_compile_options(earpoint_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(EARPOINT_SANITIZE)
  target_compile_options(earpoint_flags INTERFACE -fsanitize=${EARPOINT_SANITIZE}
                         -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(earpoint_flags INTERFACE -fsanitize=${EARPOINT_SANITIZE})
endif()

# earpoint_join_tests(<target>)
#
# Compiles several tests of a target at a time: that takes less than half the time, as their headers are read once.
# Other sources are compiled one by one, so that each is known to include what it needs.
function(earpoint_join_tests target)
  if(NOT EARPOINT_JOIN_TESTS OR NOT EARPOINT_PYTHON3)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "_test\\.cpp$")
  # An edit may give two tests of a unit the same name: they are parted when CMake runs again.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${sources})
  execute_process(COMMAND ${EARPOINT_PYTHON3} ${PROJECT_SOURCE_DIR}/cmake/units.py 6 ${sources}
                  WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE units OUTPUT_STRIP_TRAILING_WHITESPACE
                  COMMAND_ERROR_IS_FATAL ANY)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  string(REPLACE "\n" ";" units "${units}")
  set(number 0)
  foreach(unit IN LISTS units)
    math(EXPR number "${number} + 1")
    string(REPLACE " " ";" unit "${unit}")
    list(LENGTH unit length)
    if(length GREATER 1)
      set_source_files_properties(${unit} PROPERTIES UNITY_GROUP ${number})
    endif()
  endforeach()
endfunction()

# Headers that most sources include, from the standard library; apps/earpoint adds those of the command line.
set(EARPOINT_COMMON_HEADERS
  <algorithm> <array> <cmath> <complex> <cstdint> <filesystem> <functional> <map> <memory> <numeric> <optional> <set>
  <span> <string> <utility> <variant> <vector> <fmt/format.h>)

# earpoint_add_module(<name>
#   [DEPENDS <module>...]         modules whose headers it may include
#   [LIBRARIES <target>...]       outside libraries, private to the module
#   [SOURCES <file>...] [TESTS <file>...] [TEST_DEPENDS <module>...] [TEST_LIBRARIES <target>...]
#   [SUITES <suite>...])          suites of TESTS that run in one process each (earpoint_discover_tests)
#
# Makes earpoint::<name> with the include root include/ beside the CMakeLists.txt, and <name>_test from TESTS; without
# SOURCES a library of headers alone. A file may include headers of its own module and of those in DEPENDS, a test also
# of those in TEST_DEPENDS. ./dev lint checks that (cmake/check_modules.py), as the compiler also sees what these
# include.
function(earpoint_add_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" ""
    "DEPENDS;LIBRARIES;SOURCES;TESTS;TEST_DEPENDS;TEST_LIBRARIES;SUITES")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "earpoint_add_module(${name}): unknown ${arg_UNPARSED_ARGUMENTS}")
  endif()

  list(TRANSFORM arg_DEPENDS PREPEND earpoint::)
  if(NOT arg_SOURCES)
    add_library(earpoint_${name} INTERFACE)
    add_library(earpoint::${name} ALIAS earpoint_${name})
    target_include_directories(earpoint_${name} INTERFACE include)
    target_link_libraries(earpoint_${name} INTERFACE ${arg_DEPENDS})
    return()
  endif()
  add_library(earpoint_${name} STATIC ${arg_SOURCES})
  add_library(earpoint::${name} ALIAS earpoint_${name})
  target_include_directories(earpoint_${name} PUBLIC include)
  target_link_libraries(earpoint_${name}
    PUBLIC ${arg_DEPENDS}
    PRIVATE earpoint_flags fmt::fmt nlohmann_json::nlohmann_json Threads::Threads
            ${arg_LIBRARIES})
  if(EARPOINT_PRECOMPILE AND TARGET earpoint_core AND NOT name STREQUAL core)
    target_precompile_headers(earpoint_${name} REUSE_FROM earpoint_core)
  elseif(EARPOINT_PRECOMPILE)
    target_precompile_headers(earpoint_${name} PRIVATE ${EARPOINT_COMMON_HEADERS})
  endif()

  if(arg_TESTS AND BUILD_TESTING)
    add_executable(${name}_test ${arg_TESTS})
    list(TRANSFORM arg_TEST_DEPENDS PREPEND earpoint::)
    target_include_directories(${name}_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${name}_test PRIVATE earpoint::${name} ${arg_TEST_DEPENDS}
      earpoint_flags fmt::fmt nlohmann_json::nlohmann_json ${arg_TEST_LIBRARIES}
      GTest::gtest_main)
    target_compile_definitions(${name}_test PRIVATE
      EARPOINT_SOURCE_DIR="${PROJECT_SOURCE_DIR}" EARPOINT_BINARY_DIR="${PROJECT_BINARY_DIR}")
    earpoint_join_tests(${name}_test)
    earpoint_discover_tests(${name}_test LABEL ${name} SUITES ${arg_SUITES})
  endif()
endfunction()

# earpoint_discover_tests(<target> LABEL <label> [SUITES <suite>...])
#
# Makes a CTest test of each test of a program. The tests of SUITES, which share what takes seconds to make, run in one
# process and are one CTest test, named as the suite.
function(earpoint_discover_tests target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LABEL" "SUITES")
  list(TRANSFORM arg_SUITES APPEND ".*" OUTPUT_VARIABLE filter)
  list(JOIN filter ":" filter)
  if(filter)
    set(filter TEST_FILTER "-${filter}")
  endif()
  # Loading LibTorch alone can take longer than the default limit of 5 s for listing the tests.
  gtest_discover_tests(${target} ${filter} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120
    PROPERTIES TIMEOUT 600 LABELS ${arg_LABEL})
  foreach(suite IN LISTS arg_SUITES)
    add_test(NAME ${suite} COMMAND ${target} --gtest_filter=${suite}.*)
    # A filter that matches nothing is no failure to GoogleTest. COST: the long ones start first.
    set_tests_properties(${suite} PROPERTIES TIMEOUT 1200 COST 100 LABELS ${arg_LABEL}
      FAIL_REGULAR_EXPRESSION " 0 tests from 0 test suites ran")
  endforeach()
endfunction()

# earpoint_limit_simd_targets(<target>...)
#
# Limits the instruction sets that kernels and their tests are compiled for. Vectors whose length is only known at run
# time (SVE, RISC-V) do not fit the tiles; SSSE3 gains nothing on processors with SSE4.
function(earpoint_limit_simd_targets)
  foreach(target IN LISTS ARGN)
    if(TARGET ${target})
      target_compile_definitions(${target} PRIVATE
        "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128|HWY_RVV)")
    endif()
  endforeach()
endfunction()

# earpoint_add_fuzz(<name> SOURCES <file>... DEPENDS <module>...)
#
# A fuzz target: SOURCES define LLVMFuzzerTestOneInput, and fuzz_seeds/<name>/ holds inputs to start
# from, among them every input that made it fail before. With EARPOINT_FUZZ this makes the libFuzzer
# program <name> (./dev fuzz runs it); otherwise a test that replays the seeds.
function(earpoint_add_fuzz name)
  if(NOT EARPOINT_FUZZ AND NOT BUILD_TESTING)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS;SOURCES")
  list(TRANSFORM arg_DEPENDS PREPEND earpoint::)
  set(program ${name})
  if(NOT EARPOINT_FUZZ)
    set(program ${name}_replay)
    list(APPEND arg_SOURCES ${PROJECT_SOURCE_DIR}/cmake/fuzz_replay.cpp)
  endif()
  add_executable(${program} ${arg_SOURCES})
  target_include_directories(${program} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/cmake)
  target_link_libraries(${program} PRIVATE ${arg_DEPENDS} earpoint_flags fmt::fmt
                        nlohmann_json::nlohmann_json)
  if(EARPOINT_FUZZ)
    target_link_options(${program} PRIVATE -fsanitize=fuzzer)
    set_target_properties(${program} PROPERTIES
      RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/fuzz_targets)
    if(NOT TARGET fuzz_targets)
      add_custom_target(fuzz_targets)
    endif()
    add_dependencies(fuzz_targets ${program})
  else()
    add_test(NAME ${name}.SeedsDoNotBreakIt
             COMMAND ${program} ${CMAKE_CURRENT_SOURCE_DIR}/fuzz_seeds/${name})
    set_tests_properties(${name}.SeedsDoNotBreakIt PROPERTIES TIMEOUT 600 LABELS fuzz)
  endif()
endfunction()
