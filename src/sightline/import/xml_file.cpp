#include "sightline/import/xml_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sightline/readers/number_table.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

XmlFile::XmlFile(const ImportFile& file) : name_(file.name) {
  document_.Parse(file.text.data(), file.text.size());
  if (document_.Error())
    throw ScenarioError(name_, static_cast<std::size_t>(std::max(1, document_.ErrorLineNum())),
                        fmt::format("cannot be read as XML ({})", document_.ErrorName()));
  if (document_.RootElement() == nullptr)
    throw ScenarioError(name_, 1, "XML without an element, expected SDF, URDF or MJCF");
}

XmlFile::~XmlFile() = default;

const XmlFile::Element& XmlFile::root() const { return *document_.RootElement(); }

void XmlFile::refuse(const Element& at, std::string_view text, std::string_view expected) const {
  refuse_at(at, at.Name(), text, expected);
}

void XmlFile::refuse_at(const Element& at, const std::string& name, std::string_view text,
                        std::string_view expected) const {
  throw ScenarioError(
      name_, static_cast<std::size_t>(std::max(1, at.GetLineNum())),
      fmt::format("<{}> = {}, expected {}", one_line(shortened(name, 60)), shortened(text, 60), expected));
}

std::vector<double> XmlFile::parsed(const Element& at, const std::string& name, std::string_view text,
                                    std::size_t least, std::size_t most, const Range& range) const {
  constexpr std::string_view blanks = " \t\r\n\v\f";
  std::vector<double> values;
  for (std::size_t i = text.find_first_not_of(blanks); i < text.size();) {
    const std::size_t end = std::min(text.find_first_of(blanks, i), text.size());
    const std::optional<double> value = finite_number(text.substr(i, end - i));
    if (!value || !range.holds(*value)) refuse_at(at, name, text, range.expected);
    values.push_back(*value);
    i = text.find_first_not_of(blanks, end);
  }
  if (values.size() < least || values.size() > most)
    refuse_at(at, name, text,
              least == most ? fmt::format("{} numbers, {}", least, range.expected)
                            : fmt::format("{} to {} numbers, {}", least, most, range.expected));
  return values;
}

std::vector<double> XmlFile::numbers(const Element& parent, const char* element, std::size_t count,
                                     const Range& range, std::optional<double> missing) const {
  const Element* const at = parent.FirstChildElement(element);
  if (at == nullptr) {
    if (!missing)
      refuse(parent, fmt::format("without {}", element),
             fmt::format("<{}> with {}", element, range.expected));
    return std::vector<double>(count, *missing);
  }
  return parsed(*at, at->Name(), at->GetText() != nullptr ? at->GetText() : "", count, count, range);
}

std::string XmlFile::word(const Element& parent, const char* element, std::string_view expected) const {
  const Element* const at = parent.FirstChildElement(element);
  if (at == nullptr || at->GetText() == nullptr) refuse(parent, fmt::format("without {}", element), expected);
  return at->GetText();
}

std::vector<double> XmlFile::attribute(const Element& at, const char* attribute, std::size_t least,
                                       std::size_t most, const Range& range) const {
  const char* const text = at.Attribute(attribute);
  if (text == nullptr) return {};
  return parsed(at, fmt::format("{} {}", at.Name(), attribute), text, least, most, range);
}

double XmlFile::attribute(const Element& at, const char* attribute, const Range& range,
                          std::optional<double> missing) const {
  const std::vector<double> value = this->attribute(at, attribute, 1, 1, range);
  if (!value.empty()) return value[0];
  if (!missing)
    refuse(at, fmt::format("without {}", attribute), fmt::format("{} {}", attribute, range.expected));
  return *missing;
}

std::string XmlFile::attribute_word(const Element& at, const char* attribute,
                                    std::string_view expected) const {
  const char* const text = at.Attribute(attribute);
  if (text == nullptr) refuse(at, fmt::format("without {}", attribute), expected);
  return text;
}

std::vector<const tinyxml2::XMLElement*> elements_of(const tinyxml2::XMLElement& parent, const char* name) {
  std::vector<const tinyxml2::XMLElement*> all;
  for (const auto* at = parent.FirstChildElement(name); at != nullptr; at = at->NextSiblingElement(name))
    all.push_back(at);
  return all;
}

}  // namespace sightline
