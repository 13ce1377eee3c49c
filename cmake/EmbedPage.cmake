# Writes OUTPUT, a source with the script FIGURES and the files of PAGE as strings. Without PAGE it has no files, and
# names what the build LACKS for them; without FIGURES the script is empty.
cmake_policy(VERSION 3.22)
function(embed path result)
  file(READ ${path} bytes HEX)
  string(LENGTH "${bytes}" length)
  math(EXPR length "${length} / 2")
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${bytes}")
  set(${result} "{\"${bytes}\", ${length}}" PARENT_SCOPE)
endfunction()
set(files)
set(count 0)
if(PAGE)
  set(index.html "\"/\", \"text/html; charset=utf-8\"")
  set(page.js "\"/page.js\", \"text/javascript; charset=utf-8\"")
  set(page.css "\"/page.css\", \"text/css; charset=utf-8\"")
  foreach(name index.html page.js page.css)
    embed(${PAGE}/${name} bytes)
    string(APPEND files "    {${${name}}, ${bytes}},\n")
    math(EXPR count "${count} + 1")
  endforeach()
endif()
set(script "{}")
if(FIGURES)
  embed(${FIGURES} script)
endif()
# Compilers take longer strings than the standard asks of them.
file(WRITE ${OUTPUT} "#include \"sightline/report/page.hpp\"
#include \"sightline/server/page_files.hpp\"

#include <array>

#pragma GCC diagnostic ignored \"-Woverlength-strings\"

namespace sightline {

std::span<const BuiltFile> built_page() {
  static const std::array<BuiltFile, ${count}> files = {{\n${files}  }};
  return files;
}

std::string_view page_lacks() { return \"${LACKS}\"; }

std::string_view figures_script() { return ${script}; }

}  // namespace sightline
")
