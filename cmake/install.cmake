# make install: command, libraries, headers, pkg-config file, CMake package, man page.

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/airlight)

install(TARGETS airlight_shared airlight_static EXPORT airlightTargets)
if(TARGET airlight_command)
    install(TARGETS airlight_command)
endif()
if(TARGET airlight-vdb2nvdb)
    install(TARGETS airlight-vdb2nvdb)
endif()
install(DIRECTORY include/airlight TYPE INCLUDE)
install(FILES docs/airlight.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL)

# Relative paths: the prefix may still change when installing.
file(RELATIVE_PATH AIR_PC_TO_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/airlight.pc.in airlight.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/airlight.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

configure_package_config_file(cmake/airlightConfig.cmake.in airlightConfig.cmake
    INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(airlightConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT airlightTargets NAMESPACE airlight:: DESTINATION ${package_dir})
install(FILES ${PROJECT_BINARY_DIR}/airlightConfig.cmake
              ${PROJECT_BINARY_DIR}/airlightConfigVersion.cmake cmake/dependencies.cmake
        DESTINATION ${package_dir})
