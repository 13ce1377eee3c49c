/// What an exception says, as a sentence of ours.
#pragma once

#include <exception>
#include <string>

namespace sightline {

/// Its own words, where they are ours; those of std::filesystem, the JSON library and of missing memory are translated:
///
///   out/a: cannot be used (Too many levels of symbolic links), expected a file or a folder
///   no JSON from byte 17 on
///   a value of the JSON is missing or of another kind
std::string sentence_of(const std::exception& error);

}  // namespace sightline
