# The page of `sightline view`, from viewer/, as a source of the library: built_page. esbuild bundles it with three.js,
# both Debian's; the build downloads nothing. Without one of them, the program says that it has no page.
set(built_page ${generated}/built_page.cpp)
set(viewer ${PROJECT_SOURCE_DIR}/viewer)
set(embed ${CMAKE_COMMAND} -DOUTPUT=${built_page} -P ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake)
find_program(ESBUILD esbuild)
find_path(THREE_JS three/three.module.js PATHS /usr/share/javascript NO_CMAKE_FIND_ROOT_PATH
  DOC "Folder of three/, three.js of release 111")
mark_as_advanced(ESBUILD THREE_JS)
set(page_lacks)
if(NOT ESBUILD)
  list(APPEND page_lacks esbuild)
endif()
if(NOT THREE_JS)
  list(APPEND page_lacks libjs-three)
endif()
if(page_lacks)
  list(JOIN page_lacks " and " page_lacks)
  message(STATUS "sightline: without the page of view, for want of ${page_lacks}")
  list(INSERT embed 1 "-DLACKS=${page_lacks}")
  execute_process(COMMAND ${embed} COMMAND_ERROR_IS_FATAL ANY)
else()
  set(page_of_viewer ${PROJECT_BINARY_DIR}/page)
  file(GLOB viewer_sources CONFIGURE_DEPENDS ${viewer}/src/*)
  list(INSERT embed 1 -DPAGE=${page_of_viewer})
  add_custom_command(OUTPUT ${built_page}
    COMMAND ${ESBUILD} ${viewer}/src/main.js --bundle --minify --format=esm --alias:three=${THREE_JS}/three
      --target=es2022 --log-level=warning --outdir=${page_of_viewer} --entry-names=page
      "--banner:js=/*! three.js, Copyright (C) three.js authors, MIT license */"
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer}/index.html ${page_of_viewer}/index.html
    COMMAND ${embed}
    DEPENDS ${viewer_sources} ${viewer}/index.html ${THREE_JS}/three/three.module.js ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
    VERBATIM)
endif()
