# sightline_add_formulas(TARGET file.hpp) compiles the functions of one's own models and potentials into a target, so that
# they run as fast as the library's; without it they are interpreted. The header names them:
#
#   inline void sightline_formulas(sightline::Generator& generator) {
#     generator.add(MyRobot{}, sightline::Seen::pose);
#     generator.add({0.4 * MyPotential{}});
#   }
function(sightline_add_formulas target header)
  cmake_path(ABSOLUTE_PATH header BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  cmake_path(GET header STEM stem)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${target}_formulas)
  file(CONFIGURE OUTPUT ${folder}/${stem}_generate.cpp @ONLY CONTENT [[
#include "@header@"

#include "sightline/solver/generator.hpp"

int main(int, char** argv) {
  sightline::Generator generator(sightline::Generator::For::user);
  sightline_formulas(generator);
  return generator.write(argv[1]) ? 0 : 1;
}
]])
  set(generator ${target}_${stem}_generate)
  add_executable(${generator} ${folder}/${stem}_generate.cpp)
  target_link_libraries(${generator} PRIVATE sightline::sightline)
  set(kernels ${folder}/${stem}_kernels.cpp)
  add_custom_command(OUTPUT ${kernels} COMMAND ${generator} ${kernels} DEPENDS ${generator} VERBATIM)
  target_sources(${target} PRIVATE ${kernels})
endfunction()
