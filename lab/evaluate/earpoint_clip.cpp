#include <earpoint/evaluate/earpoint_clip.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// One object of the file, and what messages call it.
class Fields {
 public:
  /// @throws InputError if it is no object or has a field of another name
  Fields(const Json& object, std::string where, std::initializer_list<std::string_view> known)
      : object_(object), where_(std::move(where)) {
    if (!object.is_object()) throw InputError(where_, "expected an object");
    for (const auto& [key, value] : object.items()) {
      if (std::ranges::find(known, key) == known.end()) {
        throw InputError(where_, fmt::format("unknown field '{}'", key),
                         fmt::format("known are {}", fmt::join(known, ", ")));
      }
    }
  }

  [[nodiscard]] bool has(const char* key) const { return object_.contains(key); }

  [[nodiscard]] const Json& at(const char* key) const {
    if (!has(key)) throw InputError(where_, fmt::format("lacks '{}'", key));
    return object_[key];
  }

  [[nodiscard]] double number(const char* key) const {
    if (!at(key).is_number()) throw InputError(name(key), "expected a number");
    return at(key).get<double>();
  }

  template <std::size_t Count>
  [[nodiscard]] std::array<double, Count> numbers(const char* key) const {
    const Json& value = at(key);
    if (!value.is_array() || value.size() != Count ||
        !std::ranges::all_of(value, [](const Json& item) { return item.is_number(); })) {
      throw InputError(name(key), fmt::format("expected {} numbers", Count));
    }
    return value.get<std::array<double, Count>>();
  }

  [[nodiscard]] std::string text(const char* key) const {
    if (!at(key).is_string() || at(key).get_ref<const std::string&>().empty()) {
      throw InputError(name(key), "expected a text");
    }
    return at(key).get<std::string>();
  }

  /// @return the file's path from here
  [[nodiscard]] fs::path file(const char* key, const fs::path& folder) const {
    fs::path path = folder / text(key);
    if (!fs::is_regular_file(path)) {
      throw InputError(name(key), fmt::format("{} is not there", path.string()));
    }
    return path;
  }

  [[nodiscard]] std::string name(const char* key) const {
    return fmt::format("{}: {}", where_, key);
  }

 private:
  const Json& object_;
  std::string where_;
};

Vector3 place(const Fields& fields, const char* key) {
  const auto [x, y, z] = fields.numbers<3>(key);
  check_place({x, y, z}, fields.name(key));
  return {x, y, z};
}

Box box(const Fields& fields, const char* key) {
  const auto [x_min, y_min, x_max, y_max] = fields.numbers<4>(key);
  if (!(x_min >= 0.0 && x_min < x_max && x_max <= 1.0 && y_min >= 0.0 && y_min < y_max &&
        y_max <= 1.0)) {
    throw InputError(fields.name(key), "expected x0, y0, x1, y1 from 0 to 1, from top left");
  }
  return {x_min, y_min, x_max, y_max};
}

MapPicture map_picture(const Json& object, const std::string& where, const fs::path& folder) {
  const Fields fields(object, where, {"picture", "camera", "pixels_per_metre"});
  MapPicture map;
  map.picture = fields.file("picture", folder);
  const auto [x, y] = fields.numbers<2>("camera");
  map.camera_x = x;
  map.camera_y = y;
  map.pixels_per_metre = fields.number("pixels_per_metre");
  if (!(map.pixels_per_metre > 0.0)) {
    throw InputError(fields.name("pixels_per_metre"), "expected above 0");
  }
  return map;
}

KnownEarpoint earpoint(const Json& object, const std::string& where, const fs::path& folder) {
  const Fields fields(object, where, {"name", "translate", "yaw_deg", "truth"});
  KnownEarpoint earpoint;
  earpoint.name = fields.text("name");
  earpoint.yaw_deg = fields.number("yaw_deg");
  check_angle_deg(earpoint.yaw_deg, fields.name("yaw_deg"));
  earpoint.source_from_target = {
      place(fields, "translate"),
      quaternion_from_euler({.yaw_rad = radians_from_degrees(earpoint.yaw_deg)})};
  earpoint.truth = fields.file("truth", folder);
  return earpoint;
}

}  // namespace

EarpointClip read_earpoint_clip(const fs::path& path) {
  const std::string where = path.string();
  const Json document = Json::parse(read_text_file(path), nullptr, false);
  if (document.is_discarded()) throw InputError(where, "is not valid JSON");
  const Fields fields(document, where,
                      {"clip", "speaker", "speaker_box", "fov_deg", "map", "earpoints"});
  const fs::path folder = path.parent_path();
  EarpointClip clip;
  clip.description = path;
  clip.clip = fields.file("clip", folder);
  if (fields.has("speaker")) clip.speaker_m = place(fields, "speaker");
  if (fields.has("speaker_box")) clip.speaker_box = box(fields, "speaker_box");
  if (fields.has("fov_deg")) {
    clip.fov_deg = fields.number("fov_deg");
    if (!(*clip.fov_deg >= 10.0 && *clip.fov_deg <= 170.0)) {
      throw InputError(fields.name("fov_deg"), "expected 10 to 170 degrees");
    }
  }
  if (fields.has("map")) clip.map = map_picture(fields.at("map"), fields.name("map"), folder);
  const Json& list = fields.at("earpoints");
  if (!list.is_array() || list.empty()) {
    throw InputError(fields.name("earpoints"), "expected a list of at least one earpoint");
  }
  for (const Json& item : list) {
    const std::string name = fmt::format("{}: earpoint {}", where, clip.earpoints.size() + 1);
    KnownEarpoint known = earpoint(item, name, folder);
    if (std::ranges::find(clip.earpoints, known.name, &KnownEarpoint::name) !=
        clip.earpoints.end()) {
      throw InputError(name, fmt::format("is called '{}' like one before", known.name));
    }
    clip.earpoints.push_back(std::move(known));
  }
  return clip;
}

}  // namespace earpoint
