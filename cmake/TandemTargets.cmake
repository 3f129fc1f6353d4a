# How every target of Tandem is made: one way to make a library, one to make a test.

# Compile options of Tandem's own code. -ffp-contract=off keeps a loop's bits the same on machines
# with fused multiply-add; fast-math is never allowed (DESIGN.md, time, threads, memory).
add_library(tandem_options INTERFACE)
target_compile_options(tandem_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Wold-style-cast -Werror -ffp-contract=off -fno-math-errno -fno-trapping-math)

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
  set_target_properties(tandem_${name} PROPERTIES
    EXPORT_NAME ${name} LINKER_LANGUAGE CXX VERIFY_INTERFACE_HEADER_SETS ON CXX_EXTENSIONS OFF)
  set_property(GLOBAL APPEND PROPERTY TANDEM_LIBRARIES tandem_${name})
endfunction()

# tandem_add_test(<name> SOURCES ... LINK ... LABELS ... [ENVIRONMENT ...])
# One GoogleTest program; every TEST in it becomes one ctest entry.
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
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST
    PROPERTIES TIMEOUT ${arg_TIMEOUT} LABELS "${arg_LABELS}" ENVIRONMENT "${arg_ENVIRONMENT}")
endfunction()
