# Install and export: libraries, headers as "core/scene.h" below include/tandem, the program, the
# scenes, and what find_package(tandem COMPONENTS core ...) reads.
include(CMakePackageConfigHelpers)
set(tandem_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tandem)

get_property(tandem_libraries GLOBAL PROPERTY TANDEM_LIBRARIES)
install(TARGETS ${tandem_libraries} EXPORT tandemTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tandem)
install(EXPORT tandemTargets NAMESPACE tandem:: DESTINATION ${tandem_config_dir})

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/tandemConfig.cmake.in
  ${PROJECT_BINARY_DIR}/tandemConfig.cmake INSTALL_DESTINATION ${tandem_config_dir})
# Before 1.0 a new minor version may break the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tandemConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tandemConfig.cmake ${PROJECT_BINARY_DIR}/tandemConfigVersion.cmake
  DESTINATION ${tandem_config_dir})

if(TARGET tandem_program)
  install(TARGETS tandem_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
