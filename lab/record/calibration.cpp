#include "calibration.h"

#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include <fmt/format.h>

#include <earpoint/core/axes.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// The rotation that turns the named axis to z.
Quaternion up_turned_to_z(const JsonField& up) {
  const std::string axis = up.text();
  const double half = std::sqrt(0.5);
  if (axis == "z") return {};
  if (axis == "-z") return {.w = 0.0, .x = 1.0, .y = 0.0, .z = 0.0};
  if (axis == "y") return {.w = half, .x = half, .y = 0.0, .z = 0.0};
  if (axis == "-y") return {.w = half, .x = -half, .y = 0.0, .z = 0.0};
  if (axis == "x") return {.w = half, .x = 0.0, .y = -half, .z = 0.0};
  if (axis == "-x") return {.w = half, .x = 0.0, .y = half, .z = 0.0};
  up.fail("x, y, z, -x, -y or -z");
}

double metres_per_unit(const JsonField& units) {
  if (!units.is_text()) {
    const double metres = units.number();
    if (metres <= 0.0) units.fail("m, cm, mm, or the metres of one unit");
    return metres;
  }
  const std::string name = units.text();
  if (name == "m") return 1.0;
  if (name == "cm") return 0.01;
  if (name == "mm") return 0.001;
  units.fail("m, cm, mm, or the metres of one unit");
}

/// A camera's pose from OpenCV's x_camera = R x_world + t, in the units and frame of t.
Pose pose_from_opencv(const std::array<Vector3, 3>& rows, const Vector3& translation) {
  // The rows are the camera's right, down and front in the world.
  const Vector3 centre =
      -(rows[0] * translation.x + rows[1] * translation.y + rows[2] * translation.z);
  return {centre, quaternion_from_axes(rows[2], -rows[0], -rows[1])};
}

Pose in_our_world(const Pose& pose, const CalibrationFrame& frame) {
  return {rotate(frame.ours_from_theirs, pose.position_m * frame.metres_per_unit),
          normalized(frame.ours_from_theirs * pose.orientation)};
}

std::array<Vector3, 3> rotation_rows(const JsonField& field) {
  constexpr double kLoose = 1e-3;  // accepts files with four digits
  const std::vector<JsonField> items = field.items();
  if (items.size() != 3) field.fail("three rows of a rotation");
  const std::array<Vector3, 3> rows{items[0].vector3(), items[1].vector3(), items[2].vector3()};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (std::abs(dot(rows[i], rows[j]) - (i == j ? 1.0 : 0.0)) > kLoose) {
        field.fail("a rotation: rows of length 1 at right angles");
      }
    }
  }
  if (dot(cross(rows[0], rows[1]), rows[2]) < 0.0) field.fail("a rotation, not a mirror image");
  return rows;
}

// --- COLMAP's text files ---

/// Lines that are neither empty nor comments, with their numbers.
std::vector<std::pair<int, std::string>> colmap_lines(const std::string& text) {
  std::vector<std::pair<int, std::string>> lines;
  std::istringstream stream(text);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty() && line.front() == '#') continue;
    lines.emplace_back(number, line);
  }
  return lines;
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

double number_of(const std::string& word, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
    throw InputError(where, "expected a number, found '" + word + "'");
  }
  return value;
}

/// Indices of the parameters of a COLMAP camera model; -1 if it has none of that kind.
struct ColmapModel {
  std::size_t parameters;
  int fy;  ///< fx is always the first
  int cx;
  std::vector<int> distortion;  ///< OpenCV's order; -1 for zero
};

const std::map<std::string, ColmapModel>& colmap_models() {
  static const std::map<std::string, ColmapModel> models{
      {"SIMPLE_PINHOLE", {3, 0, 1, {}}},
      {"PINHOLE", {4, 1, 2, {}}},
      {"SIMPLE_RADIAL", {4, 0, 1, {3, -1, -1, -1}}},
      {"RADIAL", {5, 0, 1, {3, 4, -1, -1}}},
      {"OPENCV", {8, 1, 2, {4, 5, 6, 7}}},
      {"FULL_OPENCV", {12, 1, 2, {4, 5, 6, 7, 8, 9, 10, 11}}},
  };
  return models;
}

std::map<std::string, Lens> read_colmap_lenses(const fs::path& path) {
  std::map<std::string, Lens> lenses;
  for (const auto& [number, line] : colmap_lines(read_text_file(path))) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) continue;
    const std::string where = fmt::format("{}: line {}", path.string(), number);
    if (words.size() < 4) throw InputError(where, "expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    const auto model = colmap_models().find(words[1]);
    if (model == colmap_models().end()) {
      throw InputError(where, "the camera model " + words[1] + " is not known",
                       "use COLMAP with PINHOLE, RADIAL or OPENCV");
    }
    std::vector<double> numbers;
    for (std::size_t i = 2; i < words.size(); ++i) numbers.push_back(number_of(words[i], where));
    if (numbers.size() != 2 + model->second.parameters) {
      throw InputError(where, fmt::format("expected {} parameters of {}, found {}",
                                          model->second.parameters, words[1], numbers.size() - 2));
    }
    const double* parameters = numbers.data() + 2;
    Lens lens{.width_px = static_cast<int>(numbers[0]),
              .height_px = static_cast<int>(numbers[1]),
              .fx_px = parameters[0],
              .fy_px = parameters[model->second.fy],
              .cx_px = parameters[model->second.cx],
              .cy_px = parameters[model->second.cx + 1],
              .distortion = {}};
    for (const int i : model->second.distortion) {
      lens.distortion.push_back(i < 0 ? 0.0 : parameters[i]);
    }
    lenses[words[0]] = lens;
  }
  return lenses;
}

void apply_colmap(const fs::path& folder, const CalibrationFrame& frame, Session& session) {
  const std::map<std::string, Lens> lenses = read_colmap_lenses(folder / "cameras.txt");
  const fs::path images = folder / "images.txt";
  const auto lines = colmap_lines(read_text_file(images));
  // Each image has two lines: its pose, and its points, which may be an empty line.
  for (std::size_t i = 0; i < lines.size(); i += 2) {
    const std::vector<std::string> words = words_of(lines[i].second);
    const std::string where = fmt::format("{}: line {}", images.string(), lines[i].first);
    if (words.size() < 10) {
      throw InputError(where, "expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    }
    std::array<double, 7> n{};
    for (std::size_t k = 0; k < n.size(); ++k) n[k] = number_of(words[k + 1], where);
    if (std::hypot(n[0], n[1], std::hypot(n[2], n[3])) < 0.5) {
      throw InputError(where, "its rotation is not a unit quaternion");
    }
    const auto lens = lenses.find(words[8]);
    if (lens == lenses.end()) {
      throw InputError(where, "names camera " + words[8] + ", which cameras.txt does not have");
    }
    const Quaternion world_from_camera =
        conjugate(normalized(Quaternion{.w = n[0], .x = n[1], .y = n[2], .z = n[3]}));
    const Pose pose = in_our_world(pose_from_opencv({rotate(world_from_camera, {1, 0, 0}),
                                                     rotate(world_from_camera, {0, 1, 0}),
                                                     rotate(world_from_camera, {0, 0, 1})},
                                                    {n[4], n[5], n[6]}),
                                   frame);
    for (SessionCamera& camera : session.cameras) {
      if (camera.name != fs::path(words[9]).stem()) continue;
      if (!camera.lens) camera.lens = lens->second;
      if (!camera.world_from_camera) camera.world_from_camera = pose;
    }
  }
}

void apply_camera_positions(const JsonField& field, const fs::path& path, Session& session) {
  const ReplayCameras cameras = read_replay_cameras(path);
  const auto scene = cameras.find(session.scene);
  if (scene == cameras.end()) {
    throw InputError(field.where(), fmt::format("{} has no scene {}", path.string(), session.scene),
                     "give the field 'scene'");
  }
  for (SessionCamera& camera : session.cameras) {
    auto found = scene->second.find(camera.name);
    if (found == scene->second.end()) found = scene->second.find("DSLR-" + camera.name);
    if (found == scene->second.end() || camera.world_from_camera) continue;
    camera.world_from_camera = world_from_camera(found->second);
  }
}

}  // namespace

CalibrationFrame calibration_frame(const JsonField& session) {
  CalibrationFrame frame;
  if (session.has("units")) frame.metres_per_unit = metres_per_unit(session.field("units"));
  if (session.has("up")) frame.ours_from_theirs = up_turned_to_z(session.field("up"));
  if (!session.has("frame")) return frame;
  const JsonField field = session.field("frame");
  const std::string name = field.text();
  if (name != "earpoint" && name != "opencv") field.fail("\"earpoint\" or \"opencv\"");
  frame.opencv = name == "opencv";
  return frame;
}

Vector3 position_of(const JsonField& field, const CalibrationFrame& frame) {
  return rotate(frame.ours_from_theirs, field.vector3() * frame.metres_per_unit);
}

Lens lens_of(const JsonField& field) {
  field.expect_only({"width", "height", "fx", "fy", "cx", "cy", "distortion"});
  Lens lens{.width_px = field.field("width").integer(),
            .height_px = field.field("height").integer(),
            .fx_px = field.field("fx").number(),
            .fy_px = field.field("fy").number(),
            .cx_px = field.field("cx").number(),
            .cy_px = field.field("cy").number(),
            .distortion = {}};
  for (const char* key : {"width", "height", "fx", "fy"}) {
    if (field.field(key).number() <= 0.0) field.field(key).fail("more than 0");
  }
  if (!field.has("distortion")) return lens;
  for (const JsonField& item : field.field("distortion").items()) {
    lens.distortion.push_back(item.number());
  }
  const std::size_t count = lens.distortion.size();
  if (count != 0 && count != 4 && count != 5 && count != 8) {
    field.field("distortion").fail("0, 4, 5 or 8 numbers: k1, k2, p1, p2, k3, k4, k5, k6");
  }
  return lens;
}

Pose pose_of(const JsonField& field, const CalibrationFrame& frame) {
  field.expect_only({"rotation", "translation"});
  const std::array<Vector3, 3> rows = rotation_rows(field.field("rotation"));
  const Vector3 translation = field.field("translation").vector3();
  if (frame.opencv) return in_our_world(pose_from_opencv(rows, translation), frame);
  // The columns are the camera's front, left and up.
  const Quaternion orientation =
      quaternion_from_axes({rows[0].x, rows[1].x, rows[2].x}, {rows[0].y, rows[1].y, rows[2].y},
                           {rows[0].z, rows[1].z, rows[2].z});
  return in_our_world({translation, orientation}, frame);
}

void apply_calibration(const JsonField& field, const CalibrationFrame& frame, Session& session) {
  field.expect_only({"colmap", "camera_positions"});
  const auto existing = [&](const char* key) {
    fs::path path = session.file.parent_path() / field.field(key).text();
    if (!fs::exists(path)) {
      throw InputError(field.field(key).where(), fmt::format("there is no {}", path.string()));
    }
    return path;
  };
  if (field.has("colmap")) apply_colmap(existing("colmap"), frame, session);
  if (field.has("camera_positions")) {
    apply_camera_positions(field.field("camera_positions"), existing("camera_positions"), session);
  }
}

}  // namespace earpoint
