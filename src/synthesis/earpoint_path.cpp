#include <earpoint/synthesis/earpoint_path.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/csv.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::array<std::string_view, 7> kColumns = {"time_s",  "x",         "y",       "z",
                                                      "yaw_deg", "pitch_deg", "roll_deg"};
constexpr double kMayMissAtEnd_s = 0.5;

Pose make_pose(const Vector3& position_m, double yaw_deg, double pitch_deg, double roll_deg,
               const std::string& where) {
  check_place(position_m, where);
  for (const double angle_deg : {yaw_deg, pitch_deg, roll_deg}) check_angle_deg(angle_deg, where);
  return {position_m,
          quaternion_from_euler({radians_from_degrees(yaw_deg), radians_from_degrees(pitch_deg),
                                 radians_from_degrees(roll_deg)})};
}

double number(const nlohmann::json& value, const std::string& where) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    throw InputError(where, "expected a finite number, found " + value.dump());
  }
  return value.get<double>();
}

template <std::size_t Count>
std::array<double, Count> numbers(const nlohmann::json& value, const std::string& where) {
  if (!value.is_array() || value.size() != Count) {
    throw InputError(where, fmt::format("expected {} numbers, found {}", Count, value.dump()));
  }
  std::array<double, Count> result{};
  for (std::size_t i = 0; i < Count; ++i) result[i] = number(value[i], where);
  return result;
}

Pose parse_pose(const nlohmann::json& value, const std::string& where) {
  if (!value.is_object()) throw InputError(where, "expected an object like {\"position_m\": ...}");
  for (const auto& [key, unused] : value.items()) {
    static constexpr std::array<std::string_view, 5> kKeys = {"position_m", "yaw_deg", "pitch_deg",
                                                              "roll_deg", "quaternion_wxyz"};
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end()) {
      throw InputError(where, "unknown field '" + key + "'",
                       "known are position_m, yaw_deg, pitch_deg, roll_deg, quaternion_wxyz");
    }
  }
  if (!value.contains("position_m")) throw InputError(where, "position_m is missing");
  const auto [x, y, z] = numbers<3>(value["position_m"], where + ", position_m");

  if (value.contains("quaternion_wxyz")) {
    if (value.size() != 2) throw InputError(where, "give either quaternion_wxyz or angles");
    const auto q = numbers<4>(value["quaternion_wxyz"], where + ", quaternion_wxyz");
    const Quaternion quaternion{q[0], q[1], q[2], q[3]};
    const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
    // Files keep four or five digits; more than that is a mistake, not rounding.
    if (std::abs(length - 1.0) > 1e-3) {
      throw InputError(where + ", quaternion_wxyz",
                       fmt::format("its length is {:.4g}, not 1", length));
    }
    check_place({x, y, z}, where);
    return {{x, y, z}, normalized(quaternion)};
  }
  const auto angle = [&](const char* key) {
    return value.contains(key) ? number(value[key], where + ", " + key) : 0.0;
  };
  return make_pose({x, y, z}, angle("yaw_deg"), angle("pitch_deg"), angle("roll_deg"), where);
}

}  // namespace

void check_place(const Vector3& place_m, const std::string& where) {
  for (const double coordinate_m : {place_m.x, place_m.y, place_m.z}) {
    if (std::abs(coordinate_m) <= kFarthestPlace_m) continue;
    throw InputError(
        where,
        fmt::format("{:g} m is farther than the limit of {:g} m", coordinate_m, kFarthestPlace_m),
        "positions are in metres from the camera");
  }
}

void check_pose(const Pose& pose, const std::string& where) {
  check_place(pose.position_m, where);
  const Quaternion& q = pose.orientation;
  const double square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  if (std::isfinite(square) && square > 0.0) return;
  throw InputError(where,
                   fmt::format("expected an orientation, found the quaternion "
                               "({:g}, {:g}, {:g}, {:g})",
                               q.w, q.x, q.y, q.z),
                   "give a unit quaternion");
}

void check_angle_deg(double angle_deg, const std::string& where) {
  if (std::abs(angle_deg) <= kLargestDegrees) return;
  throw InputError(where, fmt::format("expected an angle in degrees, found {:g}", angle_deg));
}

EarpointPath::EarpointPath(const Pose& source_from_target) : rows_{{0.0, source_from_target}} {}

EarpointPath::EarpointPath(std::vector<Row> rows) : name_("path"), rows_(std::move(rows)) {
  if (rows_.empty()) throw InputError(name_, "has no row", "give at least one pose");
  double before_s = -std::numeric_limits<double>::infinity();
  for (const Row& row : rows_) {
    check_pose(row.pose, name_);
    if (!(row.time_s > before_s)) {
      throw InputError(name_,
                       fmt::format("time {} s does not come after {} s", row.time_s, before_s));
    }
    before_s = row.time_s;
  }
}

EarpointPath EarpointPath::from_csv(const std::filesystem::path& path) {
  return parse_csv(read_text_file(path), path.string());
}

EarpointPath EarpointPath::parse_csv(const std::string& text, const std::string& name) {
  EarpointPath path;
  path.name_ = name;
  for (const NumberRow& row : parse_number_csv(text, name, kColumns)) {
    const auto& v = row.values;
    const std::string where = fmt::format("{}: line {}", name, row.line);
    if (!path.rows_.empty() && v[0] <= path.rows_.back().time_s) {
      throw InputError(
          where, fmt::format("time {} s does not come after {} s", v[0], path.rows_.back().time_s));
    }
    path.rows_.push_back({v[0], make_pose({v[1], v[2], v[3]}, v[4], v[5], v[6], where)});
  }
  return path;
}

void EarpointPath::check_covers(double duration_s) const {
  if (!is_moving()) return;
  const double first = rows_.front().time_s;
  const double last = rows_.back().time_s;
  if (first > 0.0) {
    throw InputError(name_, fmt::format("the path starts at {:.3g} s, the clip at 0 s", first),
                     "add a row for 0 s");
  }
  if (last < duration_s - kMayMissAtEnd_s) {
    throw InputError(
        name_, fmt::format("the path ends at {:.3f} s, the clip at {:.3f} s", last, duration_s),
        fmt::format("add a row for {:.3f} s", duration_s));
  }
}

Pose EarpointPath::at(double time_s) const {
  const auto after = std::upper_bound(rows_.begin(), rows_.end(), time_s,
                                      [](double t, const Row& row) { return t < row.time_s; });
  if (after == rows_.begin()) return rows_.front().pose;
  if (after == rows_.end()) return rows_.back().pose;
  const Row& before = *std::prev(after);
  // Between equal poses no rounding may creep in.
  if (before.pose == after->pose) return before.pose;
  return interpolate(before.pose, after->pose,
                     (time_s - before.time_s) / (after->time_s - before.time_s));
}

std::vector<Pose> read_poses_json(const std::filesystem::path& path) {
  return parse_poses_json(read_text_file(path), path.string());
}

std::vector<Pose> parse_poses_json(const std::string& text, const std::string& name) {
  const nlohmann::json document = nlohmann::json::parse(text, nullptr, false);
  if (document.is_discarded()) throw InputError(name, "is not valid JSON");
  if (!document.is_array()) return {parse_pose(document, name)};
  if (document.empty()) throw InputError(name, "lists no pose");
  std::vector<Pose> poses;
  for (const nlohmann::json& value : document) {
    poses.push_back(parse_pose(value, fmt::format("{}: pose {}", name, poses.size() + 1)));
  }
  return poses;
}

}  // namespace earpoint
