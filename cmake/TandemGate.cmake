# The gate as tests, label `gate`: arrows between folders, format, lint, headers alone, install.
# `ctest -LE gate` leaves them out. Sanitizer builds have none.
if(TANDEM_TEST_LABELS OR TANDEM_TEST_PREFIX)
  return()
endif()

function(tandem_add_gate name)
  cmake_parse_arguments(arg "" "TIMEOUT" "COMMAND" ${ARGN})
  add_test(NAME gate.${name} COMMAND ${arg_COMMAND} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(gate.${name} PROPERTIES LABELS gate TIMEOUT ${arg_TIMEOUT})
endfunction()

tandem_add_gate(folders TIMEOUT 30 COMMAND scripts/check_folders)
tandem_add_gate(folders_refuses TIMEOUT 60
  COMMAND tests/gate/check_folders_test.py ${PROJECT_SOURCE_DIR}/scripts/check_folders)
tandem_add_gate(cost_page TIMEOUT 30 COMMAND bench/cost_page.py check)
tandem_add_gate(network_page TIMEOUT 30 COMMAND scripts/network_page.py check)
tandem_add_gate(format TIMEOUT 60 COMMAND scripts/format --check)

# tandem_add_gate_beside(<name> COMMAND ...): what only computes, for minutes, takes the processor time
# that tests of sessions leave over while they run alone. gate.<name> comes last and says how it ended.
function(tandem_add_gate_beside name)
  cmake_parse_arguments(arg "" "" "COMMAND" ${ARGN})
  set(folder ${PROJECT_BINARY_DIR}/beside/${name})
  tandem_add_gate(${name}_begins TIMEOUT 30
    COMMAND scripts/beside begin ${folder} ${arg_COMMAND})
  tandem_add_gate(${name} TIMEOUT 600 COMMAND scripts/beside end ${folder})
  set_tests_properties(gate.${name}_begins PROPERTIES FIXTURES_SETUP ${name} COST 1000)
  set_tests_properties(gate.${name} PROPERTIES FIXTURES_REQUIRED ${name} RUN_SERIAL ON COST -1000)
endfunction()

tandem_add_gate_beside(tidy COMMAND scripts/tidy ${PROJECT_BINARY_DIR})

# Every public header compiles alone.
tandem_add_gate_beside(headers_alone COMMAND scripts/headers_alone ${PROJECT_BINARY_DIR})

# An outside project finds, links and runs what was installed.
tandem_add_gate(install TIMEOUT 600
  COMMAND tests/install/run ${PROJECT_BINARY_DIR} ${CMAKE_CXX_COMPILER})
set_tests_properties(gate.install PROPERTIES RUN_SERIAL ON)
