#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>

#include "sightline/import/kinds.hpp"
#include "sightline/sensors.hpp"

namespace sightline {
namespace {

constexpr Range of_tag_size = {1e-3, 10, "0.001 to 10 m"};
constexpr std::int64_t tag_id_max = 586;  // of tag36h11
constexpr std::size_t bodies_max = 256;

struct ListedTag {
  std::int64_t id;
  double size;  // [m]
  std::string frame;
};
struct TaggedBody {
  std::string name;
  std::vector<ListedTag> tags;
};

/// Refuses another family than ours: "36h11", "tag36h11".
void check_family(const std::optional<YamlValue>& family) {
  if (!family) return;
  std::string name = family->text("tag36h11");
  if (!name.starts_with("tag")) name.insert(0, "tag");
  if (std::find(tag_families.begin(), tag_families.end(), name) == tag_families.end())
    family->throw_invalid(
        fmt::format("{}: tags of other families are not found", fmt::join(tag_families, " or ")));
}

std::string usual_frame(std::int64_t id) { return fmt::format("{}:{}", tag_families[0], id); }

std::string read_tag_frame(const YamlValue& at) {
  constexpr std::string_view expected = "a frame of /tf, without spaces and quotes";
  std::string frame = at.text(expected);
  if (frame.find_first_of(" \"\\") != std::string::npos) at.throw_invalid(expected);
  return frame;
}

/// The name of a body: a frame with _ for what names have not.
std::string body_name(std::string frame) {
  for (char& c : frame)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-') c = '_';
  return frame.substr(0, name_size_max);
}

/// The parameters of apriltag_ros: tag.ids with tag.frames and tag.sizes.
std::vector<ListedTag> node_tags(const YamlValue& node) {
  const std::optional<YamlValue> size = node.find("size");
  const YamlValue tag = node.at("tag", "the tags, with ids");
  const YamlValue ids = tag.at("ids", "the numbers of the tags");
  const std::vector<YamlValue> all = ids.items("the numbers of the tags");
  const auto list = [&](std::string_view key) {
    const std::optional<YamlValue> value = tag.find(key);
    const std::vector<YamlValue> items =
        value ? value->items("one for each of ids") : std::vector<YamlValue>();
    if (value && items.size() != all.size())
      value->throw_invalid(fmt::format("one for each of the {} ids", all.size()));
    return items;
  };
  const std::vector<YamlValue> frames = list("frames"), sizes = list("sizes");
  if (sizes.empty() && !size) node.at("size", "the side of the black square, in m");
  std::vector<ListedTag> tags;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::int64_t id = all[i].integer(0, tag_id_max);
    tags.push_back({id, (sizes.empty() ? *size : sizes[i]).number(of_tag_size),
                    frames.empty() ? usual_frame(id) : read_tag_frame(frames[i])});
  }
  return tags;
}

/// A list of { id, size, name }, of apriltag_ros in ROS 1, or of a body of TagSLAM.
std::vector<ListedTag> listed_tags(const YamlValue& list, const std::optional<double>& usual_size,
                                   std::vector<std::string>& notes) {
  std::vector<ListedTag> tags;
  for (const YamlValue& one : list.items("a list of tags with id and size")) {
    const std::int64_t id = one.at("id", "the number of the tag").integer(0, tag_id_max);
    const auto size = one.find("size");
    if (!size && !usual_size) one.at("size", "the side of the black square, in m");
    const auto name = one.find("name");
    tags.push_back(
        {id, size ? size->number(of_tag_size) : *usual_size, name ? read_tag_frame(*name) : usual_frame(id)});
    if (one.find("pose"))
      notes.push_back(fmt::format("{}.pose has no counterpart: plates stand upright at equal angles",
                                  one_line(one.path())));
  }
  return tags;
}

/// The bodies of TagSLAM: a list of mappings of one name each.
std::vector<TaggedBody> slam_bodies(const YamlValue& list, std::vector<std::string>& notes) {
  std::vector<TaggedBody> bodies;
  for (const YamlValue& entry : list.items("a list of bodies")) {
    for (const auto& [name, body] : entry.entries("a body by its name")) {
      const auto tags = body.find("tags");
      if (!tags) {
        notes.push_back(fmt::format("{} has no tags, left out", one_line(name)));
        continue;
      }
      const auto size = body.find("default_tag_size");
      const std::optional<double> usual = size ? std::optional(size->number(of_tag_size)) : std::nullopt;
      bodies.push_back({name, listed_tags(*tags, usual, notes)});
    }
  }
  return bodies;
}

std::string tags_table(const std::string& kind, const TaggedBody& body, const YamlValue& at) {
  const std::size_t faces = body.tags.size();
  if (faces == 0 || faces > static_cast<std::size_t>(Tags::faces_max))
    at.throw_invalid(fmt::format("1 to {} tags on {}, one a face", static_cast<int>(Tags::faces_max),
                                 one_line(body.name)));
  std::vector<std::string> frames;
  for (const ListedTag& tag : body.tags) {
    if (tag.size != body.tags[0].size)
      at.throw_invalid(fmt::format("tags of one size on {}, {} m and {} m are two", one_line(body.name),
                                   body.tags[0].size, tag.size));
    frames.push_back(fmt::format("\"{}\"", tag.frame));
  }
  return fmt::format("\n[{}.{}.tags]\nsize = {}\nfaces = {}\nframes = [{}]\n{}", kind, body_name(body.name),
                     toml_number(body.tags[0].size), faces, fmt::join(frames, ", "),
                     faces == 1 ? "distance = 0.0  # the tag is the body's origin\n" : "");
}

}  // namespace

Imported import_tags(const YamlValue& document, const std::string& file, const ImportOptions& options) {
  Imported made;
  std::vector<TaggedBody> bodies;
  std::vector<ListedTag> tags;
  const std::optional<YamlValue> node = node_parameters(document);
  const std::optional<YamlValue> listed = document.find("standalone_tags"), slam = document.find("bodies");
  check_family(node ? node->find("family") : document.find("tag_family"));
  const YamlValue& source = node ? *node : listed ? *listed : slam ? *slam : document;
  if (node) {
    tags = node_tags(*node);
  } else if (slam) {
    bodies = slam_bodies(*slam, made.notes);
  } else {
    tags = listed_tags(document.at("standalone_tags", "a list of tags"), std::nullopt, made.notes);
  }
  if (document.find("tag_bundles")) made.notes.emplace_back("tag_bundles has no counterpart");
  // The tags of one robot, or each a body of its own.
  const bool of_robot = !options.agent.empty() && !slam;
  if (of_robot) bodies.push_back({options.agent, tags});
  if (!of_robot)
    for (const ListedTag& tag : tags) bodies.push_back({tag.frame, {tag}});
  std::set<std::string> names, frames;
  for (const TaggedBody& body : bodies) {
    if (body.name.empty() || !names.insert(body_name(body.name)).second)
      source.throw_invalid(fmt::format("bodies of different names, {} is one twice", one_line(body.name)));
    for (const ListedTag& tag : body.tags)
      if (!frames.insert(tag.frame).second)
        source.throw_invalid(fmt::format("each tag once, {} is there twice", tag.frame));
  }
  if (bodies.empty() || bodies.size() > bodies_max)
    source.throw_invalid(fmt::format("1 to {} bodies with tags", bodies_max));
  made.what = fmt::format("the tags of {} bodies", bodies.size());
  made.text = fmt::format(
      "# Of {}, by `sightline import`: beside the bodies that have these tags. Plates stand upright, at "
      "equal angles, the first ahead;\n# distance and height say where.\n",
      file_name(file));
  for (const TaggedBody& body : bodies) made.text += tags_table(of_robot ? "agent" : "target", body, source);
  return made;
}

}  // namespace sightline
