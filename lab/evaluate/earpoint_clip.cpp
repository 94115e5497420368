#include <earpoint/evaluate/earpoint_clip.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

template <std::size_t Count>
std::array<double, Count> numbers(const JsonField& field) {
  const std::vector<JsonField> items = field.items();
  if (items.size() != Count) field.fail(fmt::format("{} numbers", Count));
  std::array<double, Count> values{};
  for (std::size_t i = 0; i < Count; ++i) values[i] = items[i].number();
  return values;
}

std::string name_in(const JsonField& field) {
  if (field.text().empty()) field.fail("a text");
  return field.text();
}

/// @return the file's path from here
fs::path file_in(const JsonField& field, const fs::path& folder) {
  fs::path path = folder / name_in(field);
  if (!fs::is_regular_file(path)) field.refuse(fmt::format("{} does not exist", path.string()));
  return path;
}

Vector3 place(const JsonField& field) {
  const auto [x, y, z] = numbers<3>(field);
  check_place({x, y, z}, field.where());
  return {x, y, z};
}

Box box(const JsonField& field) {
  const auto [x_min, y_min, x_max, y_max] = numbers<4>(field);
  if (!(x_min >= 0.0 && x_min < x_max && x_max <= 1.0 && y_min >= 0.0 && y_min < y_max &&
        y_max <= 1.0)) {
    field.refuse("expected x0, y0, x1, y1 from 0 to 1, from top left");
  }
  return {x_min, y_min, x_max, y_max};
}

MapPicture map_picture(const JsonField& field, const fs::path& folder) {
  field.expect_only({"picture", "camera", "pixels_per_metre"});
  MapPicture map;
  map.picture = file_in(field.field("picture"), folder);
  const auto [x, y] = numbers<2>(field.field("camera"));
  map.camera_x = x;
  map.camera_y = y;
  map.pixels_per_metre = field.field("pixels_per_metre").number();
  if (!(map.pixels_per_metre > 0.0)) field.field("pixels_per_metre").fail("above 0");
  return map;
}

KnownEarpoint earpoint(const JsonField& field, const fs::path& folder) {
  field.expect_only({"name", "translate", "yaw_deg", "truth"});
  KnownEarpoint earpoint;
  earpoint.name = name_in(field.field("name"));
  earpoint.yaw_deg = field.field("yaw_deg").number();
  check_angle_deg(earpoint.yaw_deg, field.field("yaw_deg").where());
  earpoint.source_from_target = {
      place(field.field("translate")),
      quaternion_from_euler({.yaw_rad = radians_from_degrees(earpoint.yaw_deg)})};
  earpoint.truth = file_in(field.field("truth"), folder);
  return earpoint;
}

}  // namespace

EarpointClip read_earpoint_clip(const fs::path& path) {
  constexpr int kDepth = 4;
  const nlohmann::json document = parse_strict_json(read_text_file(path), path.string(), kDepth);
  const JsonField fields(document, path.string());
  fields.expect_only({"clip", "speaker", "speaker_box", "fov_deg", "map", "earpoints"});
  const fs::path folder = path.parent_path();
  EarpointClip clip;
  clip.description = path;
  clip.clip = file_in(fields.field("clip"), folder);
  if (fields.has("speaker")) clip.speaker_m = place(fields.field("speaker"));
  if (fields.has("speaker_box")) clip.speaker_box = box(fields.field("speaker_box"));
  if (fields.has("fov_deg")) {
    clip.fov_deg = fields.field("fov_deg").number();
    if (!(*clip.fov_deg >= 10.0 && *clip.fov_deg <= 170.0)) {
      fields.field("fov_deg").fail("10 to 170 degrees");
    }
  }
  if (fields.has("map")) clip.map = map_picture(fields.field("map"), folder);
  const std::vector<JsonField> list = fields.field("earpoints").items();
  if (list.empty()) fields.field("earpoints").fail("a list of at least one earpoint");
  for (const JsonField& item : list) {
    KnownEarpoint known = earpoint(item, folder);
    if (std::ranges::find(clip.earpoints, known.name, &KnownEarpoint::name) !=
        clip.earpoints.end()) {
      item.refuse(fmt::format("is called '{}' like one before", known.name));
    }
    clip.earpoints.push_back(std::move(known));
  }
  return clip;
}

}  // namespace earpoint
