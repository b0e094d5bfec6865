# SPDX-License-Identifier: MIT
# cmake --install: headers, libraries, programs, the schema, and how CMake and pkg-config find them.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/phongsplat)

function(phongsplat_export target name set)
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} INSTALL_RPATH "$ORIGIN")
  install(TARGETS ${target} EXPORT ${set} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

phongsplat_export(phongsplat phongsplat phongsplatTargets)
phongsplat_export(phongsplat_reference reference phongsplatTargets)
install(EXPORT phongsplatTargets NAMESPACE phongsplat:: DESTINATION ${package_dir})
set(headers splat.h phongsplat.h tiles.h reference.h)
if(TARGET phongsplat_host)
  phongsplat_export(phongsplat_host host phongsplatHostTargets)
  install(EXPORT phongsplatHostTargets NAMESPACE phongsplat:: DESTINATION ${package_dir})
  list(APPEND headers host.h)
endif()
list(TRANSFORM headers PREPEND ${PROJECT_SOURCE_DIR}/runtime/include/phongsplat/)
install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/phongsplat)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/schema/ DESTINATION ${CMAKE_INSTALL_DATADIR}/phongsplat/schema)
file(RELATIVE_PATH libraries ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
foreach(program phongsplat_cli phongsplat_viewer)
  if(TARGET ${program})
    set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries}")
    install(TARGETS ${program})
  endif()
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/phongsplatConfig.cmake.in ${PROJECT_BINARY_DIR}/phongsplatConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/phongsplatConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/phongsplatConfig.cmake ${PROJECT_BINARY_DIR}/phongsplatConfigVersion.cmake
        DESTINATION ${package_dir})

# The prefix is found from where phongsplat.pc lies, so that --prefix may choose another one and the tree may be moved.
# GNUInstallDirs' directories may be absolute; an absolute one for libraries does not move, and the prefix neither.
set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
set(PHONGSPLAT_PC_PREFIX ${CMAKE_INSTALL_PREFIX})
if(NOT IS_ABSOLUTE ${pc_dir})
  set(up /)
  cmake_path(RELATIVE_PATH up BASE_DIRECTORY /${pc_dir})
  set(PHONGSPLAT_PC_PREFIX "\${pcfiledir}/${up}")
endif()
cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_LIBDIR BASE_DIRECTORY "\${prefix}" OUTPUT_VARIABLE PHONGSPLAT_PC_LIBDIR)
cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_INCLUDEDIR BASE_DIRECTORY "\${prefix}" OUTPUT_VARIABLE PHONGSPLAT_PC_INCLUDEDIR)
set(PHONGSPLAT_PC_PRIVATE "-lm")
if(PHONGSPLAT_MESHOPTIMIZER)
  set(PHONGSPLAT_PC_PRIVATE "-lmeshoptimizer -lm")
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/phongsplat.pc.in ${PROJECT_BINARY_DIR}/phongsplat.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/phongsplat.pc DESTINATION ${pc_dir})
install(FILES LICENSE LICENSE-MIT LICENSE-GPL-3.0-or-later README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
