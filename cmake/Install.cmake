# Installs the command, the library with its headers, and what find_package(boxunion) reads.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/boxunion)

install(TARGETS boxunion_command)
install(TARGETS boxunion EXPORT boxunionTargets)
install(EXPORT boxunionTargets NAMESPACE boxunion:: DESTINATION ${package_dir})
install(CODE "set(source \"${PROJECT_SOURCE_DIR}\")
set(include_dir \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\")
include(\"\${source}/cmake/InstallHeaders.cmake\")")

configure_package_config_file(cmake/boxunionConfig.cmake.in boxunionConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(boxunionConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/boxunionConfig.cmake ${PROJECT_BINARY_DIR}/boxunionConfigVersion.cmake
  DESTINATION ${package_dir})
