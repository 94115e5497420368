#include "trace_arguments.h"

#include <charconv>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Of a side of a box: below, faces would lose their area in single precision.
constexpr double kShortest_m = 0.01;

double parse_number(std::string_view flag, std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw InputError(flag, fmt::format("expected a number, found '{}'", text));
  }
  return value;
}

/// "1,2,3,name=4" taken apart.
struct Fields {
  std::vector<double> numbers;
  std::map<std::string, double, std::less<>> named;
};

Fields split(std::string_view flag, std::string_view text) {
  Fields fields;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view part = text.substr(begin, end - begin);
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) {
      fields.numbers.push_back(parse_number(flag, part));
    } else {
      fields.named[std::string(part.substr(0, equals))] =
          parse_number(flag, part.substr(equals + 1));
    }
    begin = end + 1;
  }
  return fields;
}

/// Takes out what is known and refuses the rest.
class Named {
 public:
  Named(std::string_view flag, Fields fields) : flag_(flag), left_(std::move(fields.named)) {}

  double take(std::string_view name, double otherwise) {
    const auto found = left_.find(name);
    if (found == left_.end()) return otherwise;
    const double value = found->second;
    left_.erase(found);
    return value;
  }

  void finish(std::string_view known) const {
    if (left_.empty()) return;
    throw InputError(flag_, fmt::format("unknown '{}'", left_.begin()->first),
                     fmt::format("known: {}", known));
  }

 private:
  std::string_view flag_;
  std::map<std::string, double, std::less<>> left_;
};

Vector3 three(std::string_view flag, const std::string& text, const Fields& fields) {
  if (fields.numbers.size() != 3) {
    throw InputError(flag, fmt::format("expected three numbers in metres, found '{}'", text));
  }
  return {fields.numbers[0], fields.numbers[1], fields.numbers[2]};
}

}  // namespace

Pose parse_pose(std::string_view flag, const std::string& text) {
  const Fields fields = split(flag, text);
  const Vector3 position = three(flag, text, fields);
  Named named(flag, fields);
  const EulerAngles angles{.yaw_rad = radians_from_degrees(named.take("yaw", 0.0)),
                           .pitch_rad = radians_from_degrees(named.take("pitch", 0.0)),
                           .roll_rad = radians_from_degrees(named.take("roll", 0.0))};
  named.finish("yaw, pitch and roll, in degrees");
  return {.position_m = position, .orientation = quaternion_from_euler(angles)};
}

Scene parse_shoebox(std::string_view flag, const std::string& text) {
  const Fields fields = split(flag, text);
  const Vector3 lengths_m = three(flag, text, fields);
  for (const double length_m : {lengths_m.x, lengths_m.y, lengths_m.z}) {
    if (length_m >= kShortest_m) continue;
    throw InputError(
        flag, fmt::format("expected lengths of {} m or more, found {:g}", kShortest_m, length_m));
  }
  Named named(flag, fields);
  const auto absorption = static_cast<float>(named.take("absorption", 0.2));
  const auto scattering = static_cast<float>(named.take("scattering", 0.5));
  named.finish("absorption and scattering");
  Scene scene = make_shoebox(lengths_m, all_bands(absorption), all_bands(scattering));
  check_scene(scene, flag);
  return scene;
}

}  // namespace earpoint
