# Real sockets: namespaces, netem, user-mode Linux, and the nodes in them.
find_package(nlohmann_json REQUIRED)

tandem_add_library(harness_network
  HEADERS
    caretaker.h
    child.h
    guest.h
    harness_error.h
    namespaces.h
    node_plan.h
    qdisc_player.h
    real_network.h
    real_sweep.h
    recorded_session.h
    session_batches.h
  SOURCES
    caretaker.cpp
    child.cpp
    guest.cpp
    namespaces.cpp
    node_plan.cpp
    qdisc_player.cpp
    real_network.cpp
    real_sweep.cpp
    recorded_session.cpp
    session_batches.cpp
  LINK tandem::core tandem::harness nlohmann_json::nlohmann_json
  PRIVATE_LINK tandem::recording tandem::scene fmt::fmt Threads::Threads)
