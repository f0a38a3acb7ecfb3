# Installs the files that the programs read at run time:
# PREFIX/share/lcrig/{protocols,specimens,benches,schema}; and the documents that people read.
set(LCRIG_DATA_DIR ${CMAKE_INSTALL_DATADIR}/lcrig)
install(DIRECTORY protocols/library/ DESTINATION ${LCRIG_DATA_DIR}/protocols
  FILES_MATCHING PATTERN "*.json")
file(GLOB specimens CONFIGURE_DEPENDS model/library/*.json)
file(GLOB benches CONFIGURE_DEPENDS daemon/rig/benches/*.json)
install(FILES ${specimens} DESTINATION ${LCRIG_DATA_DIR}/specimens)
install(FILES ${benches} DESTINATION ${LCRIG_DATA_DIR}/benches)
file(GLOB schemas CONFIGURE_DEPENDS schema/*.schema.json)
install(FILES ${schemas} DESTINATION ${LCRIG_DATA_DIR}/schema)
install(DIRECTORY schema/sql DESTINATION ${LCRIG_DATA_DIR}/schema FILES_MATCHING PATTERN "*.sql")

# Where each shell looks by itself; bash and fish by the name of the program.
foreach(program lcrig lcrigd lcrig-sim)
  install(FILES tools/completion/lcrig.bash RENAME ${program}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES tools/completion/lcrig.fish RENAME ${program}.fish
    DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endforeach()
install(FILES tools/completion/_lcrig DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)

set(LCRIG_DOC_DIR ${CMAKE_INSTALL_DATADIR}/doc/lcrig)
file(GLOB documents CONFIGURE_DEPENDS docs/*.md)
file(GLOB pictures CONFIGURE_DEPENDS docs/images/*.svg)
install(FILES README.md CONTRIBUTING.md DESTINATION ${LCRIG_DOC_DIR})
install(FILES ${documents} DESTINATION ${LCRIG_DOC_DIR}/docs)
install(DIRECTORY docs/decisions DESTINATION ${LCRIG_DOC_DIR}/docs FILES_MATCHING PATTERN "*.md")
install(FILES ${pictures} DESTINATION ${LCRIG_DOC_DIR}/docs/images)
