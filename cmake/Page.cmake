# The page of `sightline view`, from viewer/, as a source of the library: built_page. The build downloads nothing: where
# viewer/node_modules is missing, the program says that it has no page.
set(built_page ${generated}/built_page.cpp)
set(viewer ${PROJECT_SOURCE_DIR}/viewer)
find_program(NODE NAMES node nodejs)
if(NODE AND EXISTS ${viewer}/node_modules/vite/bin/vite.js)
  set(page_of_viewer ${PROJECT_BINARY_DIR}/page)
  file(GLOB viewer_sources CONFIGURE_DEPENDS ${viewer}/src/*)
  add_custom_command(OUTPUT ${built_page}
    COMMAND ${CMAKE_COMMAND} -E env NODE_ENV=production
      ${NODE} ${viewer}/node_modules/vite/bin/vite.js build ${viewer} --outDir ${page_of_viewer} --emptyOutDir --logLevel warn
    COMMAND ${CMAKE_COMMAND} -DPAGE=${page_of_viewer} -DOUTPUT=${built_page} -P ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
    DEPENDS ${viewer_sources} ${viewer}/index.html ${viewer}/vite.config.js ${viewer}/package-lock.json
      ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
    VERBATIM)
else()
  message(STATUS "sightline: without the page of view, for want of viewer/node_modules (npm ci --prefix viewer)")
  execute_process(COMMAND ${CMAKE_COMMAND} -DOUTPUT=${built_page} -P ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
    COMMAND_ERROR_IS_FATAL ANY)
endif()
