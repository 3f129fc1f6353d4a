# Real sockets: namespaces, netem, user-mode Linux, and the nodes in them.
find_package(nlohmann_json REQUIRED)

tandem_add_library(harness_network
  HEADERS
    caretaker.h
    child.h
    guest.h
    guest_sweep.h
    harness_error.h
    namespaces.h
    node_plan.h
    part_results.h
    qdisc_player.h
    real_network.h
    real_sweep.h
    recorded_session.h
    session_batches.h
  SOURCES
    caretaker.cpp
    child.cpp
    guest.cpp
    guest_sweep.cpp
    namespaces.cpp
    node_plan.cpp
    part_results.cpp
    qdisc_player.cpp
    real_network.cpp
    real_sweep.cpp
    recorded_session.cpp
    session_batches.cpp
  LINK tandem::core tandem::harness nlohmann_json::nlohmann_json
  PRIVATE_LINK tandem::recording tandem::scene fmt::fmt Threads::Threads)
target_compile_definitions(tandem_harness_network PRIVATE
  TANDEM_INSTALLED_LIBRARIES="${CMAKE_INSTALL_LIBDIR}/tandem")

# Loaded into user-mode Linux, which has no C++ library; without the sanitizers of this build.
add_library(tandem_guest_clock MODULE guest_clock.cpp guest_time.h)
target_link_libraries(tandem_guest_clock PRIVATE tandem_options ${CMAKE_DL_LIBS})
target_compile_features(tandem_guest_clock PRIVATE cxx_std_20)
target_compile_options(tandem_guest_clock PRIVATE
  -fno-exceptions -fno-rtti -fno-threadsafe-statics -fvisibility=hidden -fno-sanitize=all)
target_link_options(tandem_guest_clock PRIVATE -fno-sanitize=all)
target_include_directories(tandem_guest_clock PRIVATE ${PROJECT_SOURCE_DIR})
set_target_properties(tandem_guest_clock PROPERTIES
  LINKER_LANGUAGE C PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
install(TARGETS tandem_guest_clock LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/tandem)
