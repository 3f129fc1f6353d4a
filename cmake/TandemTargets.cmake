# How every target of Tandem is made: one way to make a library, one to make a test.

# The tests to build: those with one of these labels; empty means all. The sanitizer builds choose.
set(TANDEM_TEST_LABELS "" CACHE STRING "Build only tests with one of these labels; empty: all")
# Put before the names of this build's tests, so that several builds can report in one ctest run.
set(TANDEM_TEST_PREFIX "" CACHE STRING "Prefix of test names")

# Parse the largest third-party headers once a build instead of once a file; the presets say ON.
option(TANDEM_PRECOMPILE "Precompile CLI11, JSON and GoogleTest headers" OFF)

# Compile several files of one target as one: what counts is the time from nothing (the gate), where
# every file parses and instantiates the same third-party templates again. The presets say ON.
option(TANDEM_UNITY "Compile files of a target together" OFF)

# tandem_unity(<target> [batch]): lets the files of a target be compiled together, if asked for.
function(tandem_unity target)
  if(NOT TANDEM_UNITY)
    return()
  endif()
  set(batch 8)
  if(ARGC GREATER 1)
    set(batch ${ARGV1})
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
endfunction()

# Compile options of Tandem's own code. -ffp-contract=off keeps a loop's bits the same on machines
# with fused multiply-add; fast-math is never allowed (core/README.md).
# Warnings are errors, but for four of g++ 12's that raise false alarms over std::string depending on
# the length of the path the tree was cloned to: those stay warnings.
add_library(tandem_options INTERFACE)
target_compile_options(tandem_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Wold-style-cast -Werror -Wno-error=restrict -Wno-error=stringop-overflow -Wno-error=stringop-overread
  -Wno-error=array-bounds -ffp-contract=off -fno-math-errno -fno-trapping-math)

# tandem_add_library(<name> HEADERS ... SOURCES ... LINK ... PRIVATE_LINK ...)
# Headers are found as "core/clock.h" in the tree and after install alike.
function(tandem_add_library name)
  cmake_parse_arguments(arg "" "" "HEADERS;SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  add_library(tandem_${name} STATIC ${arg_SOURCES})
  add_library(tandem::${name} ALIAS tandem_${name})
  target_sources(tandem_${name} PUBLIC FILE_SET HEADERS
    BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${arg_HEADERS})
  target_include_directories(tandem_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/tandem>)
  target_link_libraries(tandem_${name} PUBLIC ${arg_LINK}
    PRIVATE $<BUILD_INTERFACE:tandem_options> ${arg_PRIVATE_LINK})
  target_compile_features(tandem_${name} PUBLIC cxx_std_20)
  # The worlds are templates in headers: whoever includes them needs this for the same bits.
  target_compile_options(tandem_${name} PUBLIC -ffp-contract=off)
  set_target_properties(tandem_${name} PROPERTIES
    EXPORT_NAME ${name} LINKER_LANGUAGE CXX VERIFY_INTERFACE_HEADER_SETS ON CXX_EXTENSIONS OFF)
  tandem_unity(tandem_${name})
  set_property(GLOBAL APPEND PROPERTY TANDEM_LIBRARIES tandem_${name})
endfunction()

# Sets `result` to whether a test with these labels belongs to this build (TANDEM_TEST_LABELS).
function(tandem_test_is_chosen result)
  set(chosen ON)
  if(TANDEM_TEST_LABELS)
    set(chosen OFF)
    foreach(label IN LISTS ARGN)
      if(label IN_LIST TANDEM_TEST_LABELS)
        set(chosen ON)
      endif()
    endforeach()
  endif()
  set(${result} ${chosen} PARENT_SCOPE)
endfunction()

# Tests, and the program's options and tables, wait for compilers longer than they run: in release
# builds their own sources are compiled at -O1, the libraries as always. Hard cases are for optimised
# code (label `hard`).
set(tandem_light_options $<$<CONFIG:Release>:-O1>)

# Lets a test use precompiled GoogleTest headers; they belong to a small program made for that.
function(tandem_precompile_gtest test)
  if(NOT TANDEM_PRECOMPILE)
    return()
  endif()
  if(NOT TARGET tandem_precompiled_gtest)
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled_gtest.cpp CONTENT "int main() {}\n")
    add_executable(tandem_precompiled_gtest EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled_gtest.cpp)
    target_link_libraries(tandem_precompiled_gtest PRIVATE GTest::gtest tandem_options)
    target_compile_features(tandem_precompiled_gtest PRIVATE cxx_std_20)
    target_compile_options(tandem_precompiled_gtest PRIVATE ${tandem_light_options})
    set_target_properties(tandem_precompiled_gtest PROPERTIES CXX_EXTENSIONS OFF)
    target_precompile_headers(tandem_precompiled_gtest PRIVATE <gtest/gtest.h>)
  endif()
  target_precompile_headers(${test} REUSE_FROM tandem_precompiled_gtest)
endfunction()

# tandem_add_test(<name> SOURCES ... LINK ... LABELS ... [ENVIRONMENT ...] [TIMEOUT seconds])
# One GoogleTest program; every TEST in it becomes one ctest entry. Target `tandem_tests` builds all.
function(tandem_add_test name)
  cmake_parse_arguments(arg "" "TIMEOUT" "SOURCES;LINK;LABELS;ENVIRONMENT" ${ARGN})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 120)
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_LINK} GTest::gtest_main tandem_options)
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_compile_definitions(${name} PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests
    CXX_EXTENSIONS OFF)
  if(NOT "hard" IN_LIST arg_LABELS)
    target_compile_options(${name} PRIVATE ${tandem_light_options})
    tandem_precompile_gtest(${name})
  endif()
  tandem_test_is_chosen(chosen ${arg_LABELS})
  if(NOT chosen)
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    return()
  endif()
  # What measures real time is not run beside something else.
  set(alone OFF)
  if("system" IN_LIST arg_LABELS OR "realtime" IN_LIST arg_LABELS)
    set(alone ON)
  endif()
  if(NOT TARGET tandem_tests)
    add_custom_target(tandem_tests)
  endif()
  add_dependencies(tandem_tests ${name})
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${TANDEM_TEST_PREFIX}")
  # Its PROPERTIES take no lists and no empty values; what ctest includes after the discovery does.
  set(properties ${CMAKE_CURRENT_BINARY_DIR}/${name}_properties.cmake)
  file(CONFIGURE OUTPUT ${properties} @ONLY CONTENT [[
if(@name@_TESTS)
  set_tests_properties(${@name@_TESTS} PROPERTIES
    TIMEOUT @arg_TIMEOUT@ LABELS "@arg_LABELS@" ENVIRONMENT "@arg_ENVIRONMENT@" RUN_SERIAL @alone@)
endif()
]])
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${properties})
endfunction()

# tandem_add_program_at(<name> FLAGS ... SOURCES ... LINK ...)
# One small program whose own sources are compiled with other flags than the build's: FLAGS come
# last, so `-O0` or `-O3 -march=native` win over the build type. Laws and loops are instantiated in
# .cpp files: pass those as SOURCES too where they matter.
function(tandem_add_program_at name)
  cmake_parse_arguments(arg "" "" "FLAGS;SOURCES;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_LINK} tandem_options)
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_compile_options(${name} PRIVATE ${arg_FLAGS})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests
    CXX_EXTENSIONS OFF)
endfunction()

# tandem_add_schema(<target> <file.proto>): compiles a schema into a library; its own sources include it
# as "FOLDER/NAME.pb.h". Generated code is compiled without our warnings and stays inside.
function(tandem_add_schema target proto)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/generated)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  file(MAKE_DIRECTORY ${generated}/${folder})
  protobuf_generate(LANGUAGE cpp OUT_VAR sources PROTOC_OUT_DIR ${generated}/${folder}
    PROTOS ${CMAKE_CURRENT_SOURCE_DIR}/${proto})
  set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS "-w")
  target_sources(${target} PRIVATE ${sources})
  target_include_directories(${target} SYSTEM PRIVATE $<BUILD_INTERFACE:${generated}>)
  target_link_libraries(${target} PRIVATE protobuf::libprotobuf)
endfunction()
