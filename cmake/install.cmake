# SPDX-License-Identifier: Apache-2.0
# Everything that `cmake --install` writes, except what tools/ installs beside its own targets.
# cmake/install_manifest.txt lists the result; the test packaging.manifest compares.

include(CMakePackageConfigHelpers)

set(zt_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/zt)
foreach(kind shared static)
  if(TARGET zt_${kind})
    install(TARGETS zt_${kind} EXPORT zt-${kind})
    install(EXPORT zt-${kind} NAMESPACE zt:: DESTINATION ${zt_package_dir})
  endif()
endforeach()
install(DIRECTORY libzt/include/zt DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")

configure_package_config_file(cmake/ztConfig.cmake.in ${PROJECT_BINARY_DIR}/ztConfig.cmake
  INSTALL_DESTINATION ${zt_package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ztConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ztConfig.cmake ${PROJECT_BINARY_DIR}/ztConfigVersion.cmake
  DESTINATION ${zt_package_dir})

# The prefix is known only when installing, and it may differ from the one configured.
install(CODE "
  set(PROJECT_DESCRIPTION [==[${PROJECT_DESCRIPTION}]==])
  set(PROJECT_VERSION ${PROJECT_VERSION})
  set(CMAKE_INSTALL_LIBDIR ${CMAKE_INSTALL_LIBDIR})
  set(CMAKE_INSTALL_INCLUDEDIR ${CMAKE_INSTALL_INCLUDEDIR})
  configure_file(\"${PROJECT_SOURCE_DIR}/cmake/zt.pc.in\" \"${PROJECT_BINARY_DIR}/zt.pc\" @ONLY)")
install(FILES ${PROJECT_BINARY_DIR}/zt.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} OPTIONAL)
install(DIRECTORY spec DESTINATION ${CMAKE_INSTALL_DOCDIR}
  FILES_MATCHING PATTERN "*.md" PATTERN "*.ksy" PATTERN "*.hex")
install(FILES share/ztex.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages)
install(FILES share/ztex.magic DESTINATION ${CMAKE_INSTALL_DATADIR}/zt)
