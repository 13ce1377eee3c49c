/// An XML file with typed and range-checked access; every error states file, line, element, text and
/// what was expected.
#pragma once

#include <tinyxml2.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/range.hpp"
#include "sightline/import/import.hpp"

namespace sightline {

/// A file with its elements. Every function throws ScenarioError.
class XmlFile {
 public:
  using Element = tinyxml2::XMLElement;

  /// @throws ScenarioError for a text that is no XML
  explicit XmlFile(const ImportFile& file);
  // Both are in the library, so that its users need no tinyxml2.
  ~XmlFile();
  const Element& root() const;

  const std::string& name() const { return name_; }

  /// `file:line: <name> = text, expected ...`
  [[noreturn]] void refuse(const Element& at, std::string_view text, std::string_view expected) const;

  /// `count` numbers in the text of an element of `parent`; without it those of `missing`, or none of
  /// which it must have.
  std::vector<double> numbers(const Element& parent, const char* element, std::size_t count,
                              const Range& range, std::optional<double> missing = std::nullopt) const;
  double number(const Element& parent, const char* element, const Range& range,
                std::optional<double> missing = std::nullopt) const {
    return numbers(parent, element, 1, range, missing)[0];
  }
  std::string word(const Element& parent, const char* element, std::string_view expected) const;

  /// `least` to `most` numbers of an attribute; empty without it.
  std::vector<double> attribute(const Element& at, const char* attribute, std::size_t least, std::size_t most,
                                const Range& range) const;
  /// The number of an attribute, which is `missing` without it, or must be there.
  double attribute(const Element& at, const char* attribute, const Range& range,
                   std::optional<double> missing = std::nullopt) const;
  /// The text of an attribute that must be there.
  std::string attribute_word(const Element& at, const char* attribute, std::string_view expected) const;

 private:
  [[noreturn]] void refuse_at(const Element& at, const std::string& name, std::string_view text,
                              std::string_view expected) const;
  std::vector<double> parsed(const Element& at, const std::string& name, std::string_view text,
                             std::size_t least, std::size_t most, const Range& range) const;

  std::string name_;
  tinyxml2::XMLDocument document_;
};

/// The elements of `parent` with a name, or all.
std::vector<const tinyxml2::XMLElement*> elements_of(const tinyxml2::XMLElement& parent,
                                                     const char* name = nullptr);

}  // namespace sightline
