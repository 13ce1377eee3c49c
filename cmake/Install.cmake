# What find_package(sightline COMPONENTS core sightline cli mujoco dds) and pkg-config need; pages; and the package of `cpack -G DEB`.
include(CMakePackageConfigHelpers)
set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sightline)

# The public headers, each of the component whose library it describes.
set(headers barrier base estimator events formula kernels loop model potential potentials robots sensors sightline solver
  solvers supervisor team vehicle world worlds)
set(components core)
install(TARGETS sightline_core EXPORT sightline_core)
if(TARGET sightline)
  list(APPEND headers judge log registry report scenario)
  if(campaign_FOUND OR analysis_FOUND)
    list(APPEND headers analysis)
  endif()
  list(APPEND components sightline)
  install(TARGETS sightline EXPORT sightline_sightline)
endif()
if(TARGET sightline_command_line)
  list(APPEND headers command_line)
  list(APPEND components cli)
  install(TARGETS sightline_command_line EXPORT sightline_cli)
  install(TARGETS sightline_cli)
endif()
if(TARGET sightline_mujoco)
  list(APPEND headers mujoco)
  list(APPEND components mujoco)
  install(TARGETS sightline_mujoco EXPORT sightline_mujoco)
  install(FILES cmake/FindMuJoCo.cmake cmake/FindEGL.cmake DESTINATION ${config_dir})
endif()
if(TARGET sightline_dds)
  list(APPEND headers dds)
  list(APPEND components dds)
  install(TARGETS sightline_dds EXPORT sightline_dds)
endif()
list(TRANSFORM headers REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/include/sightline/\\1.hpp")
install(FILES ${headers} ${generated}/sightline/config.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/sightline)

foreach(component IN LISTS components)
  install(EXPORT sightline_${component} NAMESPACE sightline:: DESTINATION ${config_dir}
    FILE sightline_${component}.cmake)
endforeach()
set(needed_by_mujoco MuJoCo)
if(camera_pictures)
  list(APPEND needed_by_mujoco EGL apriltag)
endif()
set(static ON)
if(BUILD_SHARED_LIBS)
  set(static OFF)
endif()
configure_package_config_file(cmake/sightlineConfig.cmake.in ${generated}/sightlineConfig.cmake
  INSTALL_DESTINATION ${config_dir} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${generated}/sightlineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/SightlineFormulas.cmake ${generated}/sightlineConfig.cmake ${generated}/sightlineConfigVersion.cmake
  DESTINATION ${config_dir})

# For pkg-config. A shared library brings along what it is linked with.
list(JOIN numerics_of_users " " pc_flags)
file(RELATIVE_PATH pc_to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
function(sightline_pc name description library requires links)
  set(private .private)
  if(NOT BUILD_SHARED_LIBS)
    set(private)
  endif()
  configure_file(cmake/sightline.pc.in ${generated}/${name}.pc @ONLY)
  install(FILES ${generated}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
sightline_pc(sightline_core "${PROJECT_DESCRIPTION}: formulas, solvers, safety" sightline_core fmt "")
if(TARGET sightline)
  sightline_pc(sightline "${PROJECT_DESCRIPTION}: scenarios, logs, reports too"
    sightline sightline_core "libzstd sqlite3 tomlplusplus zlib")
endif()

# Manual pages and completion, as the command line describes itself.
find_program(GZIP gzip)
if(TARGET sightline_command_line AND GZIP)
  set(pages ${PROJECT_BINARY_DIR}/pages)
  add_executable(sightline_pages tools/pages.cpp)
  target_compile_options(sightline_pages PRIVATE ${numerics} ${warnings})
  target_include_directories(sightline_pages PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(sightline_pages PRIVATE sightline_command_line CLI11::CLI11)
  add_custom_command(OUTPUT ${pages}/sightline
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${pages}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${pages}/man1
    COMMAND sightline_pages ${pages}
    COMMAND ${GZIP} -9nr ${pages}/man1
    DEPENDS sightline_pages VERBATIM)
  add_custom_target(sightline_page_files ALL DEPENDS ${pages}/sightline)
  install(DIRECTORY ${pages}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR})
  install(FILES ${pages}/sightline DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
endif()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/sightline RENAME copyright)
install(FILES package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/sightline)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
set(CPACK_PACKAGE_VENDOR "The sightline authors")
set(CPACK_PACKAGE_CONTACT "The sightline authors <sightline@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})
if(TARGET sightline_python)
  # It imports numpy; the rest of the package does without.
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS python3-numpy)
endif()
# Who links the libraries needs what they are linked with.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
  "cmake, cyclonedds-dev, g++, libapriltag-dev, libegl-dev, libfmt-dev, libmujoco-dev, libsqlite3-dev, libssl-dev, libtomlplusplus-dev, libzstd-dev, pkg-config, zlib1g-dev")
include(CPack)
