# The page of `sightline view` and the script of report pages, from viewer/, as a source of the library: built_page.
# esbuild bundles them, the page with three.js, both Debian's; the build downloads nothing. A program without one of them
# says so.
set(built_page ${generated}/built_page.cpp)
set(viewer ${PROJECT_SOURCE_DIR}/viewer)
set(pages ${PROJECT_BINARY_DIR}/page)
find_program(ESBUILD esbuild)
find_path(THREE_JS three/three.module.js PATHS /usr/share/javascript NO_CMAKE_FIND_ROOT_PATH
  DOC "Folder of three/, three.js of release 111")
mark_as_advanced(ESBUILD THREE_JS)
file(GLOB viewer_sources CONFIGURE_DEPENDS ${viewer}/src/*)
set(page_lacks)
set(bundled)
set(embedded)
if(ESBUILD)
  set(bundle ${ESBUILD} --bundle --minify --target=es2022 --log-level=warning)
  list(APPEND bundled COMMAND ${bundle} ${viewer}/src/figures.js --format=iife --outfile=${pages}/figures.js)
  list(APPEND embedded -DFIGURES=${pages}/figures.js)
else()
  list(APPEND page_lacks esbuild)
endif()
if(NOT THREE_JS)
  list(APPEND page_lacks libjs-three)
endif()
if(page_lacks)
  list(JOIN page_lacks " and " page_lacks)
  message(STATUS "sightline: without the page of view, for want of ${page_lacks}")
  list(APPEND embedded "-DLACKS=${page_lacks}")
elseif(server_FOUND)
  set(page_of_viewer ${pages})
  list(APPEND bundled
    COMMAND ${bundle} ${viewer}/src/main.js --format=esm --alias:three=${THREE_JS}/three --outdir=${pages}
      --entry-names=page "--banner:js=/*! three.js, Copyright (C) three.js authors, MIT license */"
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer}/index.html ${pages}/index.html)
  list(APPEND embedded -DPAGE=${pages})
  list(APPEND viewer_sources ${viewer}/index.html ${THREE_JS}/three/three.module.js)
endif()
add_custom_command(OUTPUT ${built_page} ${bundled}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${built_page} ${embedded} -P ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
  DEPENDS ${viewer_sources} ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
  VERBATIM)
