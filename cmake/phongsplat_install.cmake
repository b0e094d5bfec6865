# SPDX-License-Identifier: MIT
# cmake --install: headers, libraries, the command line, and how CMake and pkg-config find them.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/phongsplat)

function(phongsplat_export target name set)
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS ${target} EXPORT ${set} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

phongsplat_export(phongsplat phongsplat phongsplatTargets)
phongsplat_export(phongsplat_reference reference phongsplatTargets)
install(EXPORT phongsplatTargets NAMESPACE phongsplat:: DESTINATION ${package_dir})
set(headers splat.h phongsplat.h reference.h)
if(TARGET phongsplat_host)
  phongsplat_export(phongsplat_host host phongsplatHostTargets)
  install(EXPORT phongsplatHostTargets NAMESPACE phongsplat:: DESTINATION ${package_dir})
  list(APPEND headers host.h)
endif()
list(TRANSFORM headers PREPEND ${PROJECT_SOURCE_DIR}/runtime/include/phongsplat/)
install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/phongsplat)
foreach(program phongsplat_cli phongsplat_viewer)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/phongsplatConfig.cmake.in ${PROJECT_BINARY_DIR}/phongsplatConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/phongsplatConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/phongsplatConfig.cmake ${PROJECT_BINARY_DIR}/phongsplatConfigVersion.cmake
        DESTINATION ${package_dir})

# GNUInstallDirs' directories may be absolute.
cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_LIBDIR BASE_DIRECTORY "\${prefix}" OUTPUT_VARIABLE PHONGSPLAT_PC_LIBDIR)
cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_INCLUDEDIR BASE_DIRECTORY "\${prefix}" OUTPUT_VARIABLE PHONGSPLAT_PC_INCLUDEDIR)
set(PHONGSPLAT_PC_PRIVATE "-lm")
if(PHONGSPLAT_MESHOPTIMIZER)
  set(PHONGSPLAT_PC_PRIVATE "-lmeshoptimizer -lm")
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/phongsplat.pc.in ${PROJECT_BINARY_DIR}/phongsplat.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/phongsplat.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES LICENSE LICENSE-MIT LICENSE-GPL-3.0-or-later README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
