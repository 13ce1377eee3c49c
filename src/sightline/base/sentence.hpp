/// Text of an exception as one sentence in the form of sightline.
#pragma once

#include <exception>
#include <string>

namespace sightline {

/// The text of an exception of sightline is returned unchanged. Exceptions of std::filesystem, of
/// the JSON library and for missing memory are translated:
///
///   out/a: cannot be used (Too many levels of symbolic links), expected a file or a folder
///   no JSON from byte 17 on
///   a value of the JSON is missing or of another kind
std::string sentence_of(const std::exception& error);

}  // namespace sightline
