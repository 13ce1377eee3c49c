# sightline_add_formulas(TARGET file.hpp) compiles the functions of one's own models and potentials into a target, so that
# they run as fast as the library's; without it they are interpreted, and give the same bits. The header names them, with
# any numbers: a function serves all.
#
#   #include <sightline/kernels.hpp>
#
#   inline void sightline_formulas(sightline::Generator& generator) {
#     using namespace sightline;
#     generator.add(MyRobot{}, Seen::pose);
#     generator.add({0.4 * MyPotential{}});                    # alone, and beside the library's
#     generator.add({0.4 * MyPotential{}, 0.4 * KeepOut{}});   # as one function with another: a little faster
#   }
#
# They are built with the flags of the library, SIGHTLINE_KERNEL_FLAGS, and run on the machines that it runs on.
# Where TARGET is a static library, its functions go to the programs that link it.
function(sightline_add_formulas target header)
  if(NOT TARGET ${target})
    message(FATAL_ERROR "sightline_add_formulas: TARGET = ${target}, expected a target that exists already")
  endif()
  cmake_path(ABSOLUTE_PATH header BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  if(NOT EXISTS ${header})
    message(FATAL_ERROR "sightline_add_formulas: file = ${header}, expected a header that exists")
  endif()
  cmake_path(GET header STEM stem)
  set(name ${target}_${stem})
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${name})
  file(CONFIGURE OUTPUT ${folder}/generate.cpp @ONLY CONTENT [[
#include "@header@"

#include <cstdio>

#include "sightline/kernels.hpp"

int main(int, char** argv) {
  sightline::Generator generator;
  sightline_formulas(generator);
  if (sightline::write_text(argv[1], generator.text())) return 0;
  std::fprintf(stderr, "%s: not written, expected a file that can be\n", argv[1]);
  return 1;
}
]])
  add_executable(${name}_generate ${folder}/generate.cpp)
  set_target_properties(${name}_generate PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${folder})
  target_include_directories(${name}_generate PRIVATE $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
  target_compile_definitions(${name}_generate PRIVATE $<TARGET_PROPERTY:${target},COMPILE_DEFINITIONS>)
  target_link_libraries(${name}_generate PRIVATE sightline::core)

  set(kernels ${folder}/kernels.cpp)
  add_custom_command(OUTPUT ${kernels} COMMAND ${name}_generate ${kernels} DEPENDS ${name}_generate VERBATIM)
  add_library(${name}_kernels OBJECT ${kernels})
  target_link_libraries(${name}_kernels PRIVATE sightline::core)
  # They are what takes the time of an update, whatever the rest is built with.
  get_target_property(flags sightline::core SIGHTLINE_KERNEL_FLAGS)
  target_compile_options(${name}_kernels PRIVATE ${flags} $<$<NOT:$<CONFIG:Debug>>:-O3>)
  set_target_properties(${name}_kernels PROPERTIES POSITION_INDEPENDENT_CODE ON)

  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    target_sources(${target} INTERFACE $<TARGET_OBJECTS:${name}_kernels>)
  else()
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${name}_kernels>)
  endif()
endfunction()
