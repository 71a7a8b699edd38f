# SPDX-License-Identifier: MIT
# The Debian package flotillad, by CPack: tools/package runs it, the presets deb-ARCH ask for it.
set(HERE ${CMAKE_CURRENT_SOURCE_DIR})
set(MADE ${CMAKE_CURRENT_BINARY_DIR}/package)

# 0.1+20261121020214.619cf70a: a later commit is a later version, and says which it is.
set(PACKAGE_VERSION ${PROJECT_VERSION})
set(COMMITTED "Thu, 01 Jan 1970 00:00:00 +0000")
if(NOT no_git)
  function(committed result format)
    execute_process(COMMAND ${CMAKE_COMMAND} -E env TZ=UTC
      git -C ${CMAKE_SOURCE_DIR} log -1 --format=%cd "--date=format-local:${format}"
      OUTPUT_VARIABLE text OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    set(${result} ${text} PARENT_SCOPE)
  endfunction()
  committed(stamp "%Y%m%d%H%M%S")
  committed(COMMITTED "%a, %d %b %Y %T +0000")
  string(APPEND PACKAGE_VERSION +${stamp}.${REVISION})
  execute_process(COMMAND git -C ${CMAKE_SOURCE_DIR} diff --quiet HEAD RESULT_VARIABLE changed)
  if(changed)
    string(APPEND PACKAGE_VERSION +changed)
  endif()
endif()

# dpkg-shlibdeps does not find a cross compiler's libraries. Whoever has the libraries of the
# compiler, or later ones, has all symbols.
execute_process(COMMAND ${CMAKE_CXX_COMPILER} -E -dM -x c++ -include features.h /dev/null
  OUTPUT_VARIABLE macros COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "__GLIBC__ ([0-9]+)" glibc "${macros}")
set(glibc ${CMAKE_MATCH_1})
string(REGEX MATCH "__GLIBC_MINOR__ ([0-9]+)" glibc_minor "${macros}")
string(APPEND glibc .${CMAKE_MATCH_1})
string(REGEX MATCH "^[0-9]+" gcc ${CMAKE_CXX_COMPILER_VERSION})

set(CPACK_PACKAGE_CONTACT "Flotilla developers <flotilla@users.noreply.github.com>")
configure_file(${HERE}/package/changelog.in ${MADE}/changelog @ONLY)
foreach(name IN ITEMS changelog flotillad.8)
  find_file(${name}_SOURCE ${name} PATHS ${MADE} ${HERE}/package NO_DEFAULT_PATH REQUIRED)
  execute_process(COMMAND gzip -9nc ${${name}_SOURCE} OUTPUT_FILE ${MADE}/${name}.gz
    COMMAND_ERROR_IS_FATAL ANY)
endforeach()

install(TARGETS flotillad DESTINATION usr/bin)
install(FILES ${HERE}/flotillad.service DESTINATION lib/systemd/system)
install(FILES ${HERE}/boat.toml DESTINATION etc/flotilla)
install(FILES ${HERE}/package/can0.network DESTINATION etc/systemd/network
  RENAME 60-flotilla-can0.network)
install(FILES ${HERE}/package/sysusers.conf DESTINATION usr/lib/sysusers.d RENAME flotillad.conf)
install(FILES ${MADE}/flotillad.8.gz DESTINATION usr/share/man/man8)
install(FILES ${MADE}/changelog.gz ${HERE}/package/copyright DESTINATION usr/share/doc/flotillad)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME flotillad)
set(CPACK_PACKAGE_VERSION ${PACKAGE_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "autopilot of a twin-propeller boat: MAVLink in, DroneCAN out")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"Hears its own and its leader's state by MAVLink, computes two thrusts that
keep its slot in a formation, and commands two motor controllers by DroneCAN.

It runs as a service of its own user, configured in /etc/flotilla/boat.toml.")
set(CPACK_PACKAGING_INSTALL_PREFIX /)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_SOURCE_DIR}/build/packages)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${FLOTILLA_PACKAGE})
set(CPACK_DEBIAN_PACKAGE_SECTION net)
set(CPACK_DEBIAN_PACKAGE_DEPENDS
  "libc6 (>= ${glibc}), libgcc-s1 (>= ${gcc}), libstdc++6 (>= ${gcc}), systemd")
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  ${HERE}/package/conffiles ${HERE}/package/postinst ${HERE}/package/prerm ${HERE}/package/postrm)
include(CPack)
