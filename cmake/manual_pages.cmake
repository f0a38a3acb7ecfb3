# Manual pages, where scdoc and Python are there: the target `man`, part of a whole build. The commands
# of lcrig.1 are what the program itself says of them.
find_program(SCDOC scdoc)
find_package(Python3 COMPONENTS Interpreter)
if(NOT SCDOC OR NOT Python3_FOUND)
  message(STATUS "scdoc or python3 is not there: no manual pages")
  return()
endif()
set(man_folder ${CMAKE_BINARY_DIR}/man)
file(GLOB man_sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/docs/man/*.scd)
file(GLOB documents CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/docs/*.md)
set(man_pages "")
set(man_commands "")
foreach(source ${man_sources})
  cmake_path(GET source STEM LAST_ONLY page)  # lcrig.1
  list(APPEND man_pages ${man_folder}/${page})
  list(APPEND man_commands COMMAND ${SCDOC} < ${man_folder}/${page}.scd > ${man_folder}/${page})
  string(REGEX MATCH "[0-9]$" section ${page})
  install(FILES ${man_folder}/${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man${section} OPTIONAL)
endforeach()
set(make_pages ${CMAKE_SOURCE_DIR}/tools/man/make_pages)
add_custom_command(OUTPUT ${man_pages}
  COMMAND ${Python3_EXECUTABLE} ${make_pages} ${man_folder} ${PROJECT_VERSION} $<TARGET_FILE:lcrig>
  ${man_commands}
  DEPENDS lcrig ${make_pages} ${man_sources} ${documents}
  WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} VERBATIM)
add_custom_target(man ALL DEPENDS ${man_pages})
