#include <earpoint/spatial/sofa_file.h>

#include "sofa_contents.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr std::string_view kConvention = "SimpleFreeFieldHRIR";
constexpr std::string_view kDefaultSet = "libmysofa/MIT_KEMAR_normal_pinna.sofa";
constexpr std::uint64_t kMostTaps = 65536;
constexpr std::string_view kHint = "use another set of head-related impulse responses";

// One file being read; every refusal names it.
class Reader {
 public:
  Reader(const std::filesystem::path& path, const SofaContents& sofa) : path_(path), sofa_(sofa) {}

  SofaFile read() const;

 private:
  [[noreturn]] void refuse(std::string_view field, const std::string& problem) const {
    throw InputError(fmt::format("{}: {}", path_.string(), field), problem, kHint);
  }
  void check_convention() const;
  /// The variable of that name after checking its size: `one` set of values for all measurements
  /// or `all`, a set for each.
  const SofaVariable& variable(std::string_view name, std::size_t one, std::size_t all) const;
  Vector3 coordinates(std::string_view field, const SofaVariable& variable, std::string_view type,
                      std::size_t index) const;
  void check_units(std::string_view field, const SofaVariable& variable,
                   std::string_view type) const;
  std::array<int, 2> receivers_left_right() const;
  int sample_rate_hz() const;
  void read_positions(SofaFile& file) const;
  void read_responses(SofaFile& file) const;
  void check_left_is_left(const SofaFile& file) const;

  const std::filesystem::path& path_;
  const SofaContents& sofa_;
};

void Reader::check_convention() const {
  if (sofa_.convention != kConvention) {
    refuse("SOFAConventions",
           fmt::format("expected {}, found '{}'", kConvention, sofa_.convention));
  }
  if (sofa_.data_type != "FIR") {
    refuse("DataType", fmt::format("expected FIR, found '{}'", sofa_.data_type));
  }
  if (sofa_.receivers != 2) {
    refuse("R", fmt::format("expected 2 receivers, found {}", sofa_.receivers));
  }
  constexpr std::uint64_t kMostMeasurements = 1000000;
  if (sofa_.measurements == 0 || sofa_.measurements > kMostMeasurements) {
    refuse("M", fmt::format("expected 1 to {} measurements, found {}", kMostMeasurements,
                            sofa_.measurements));
  }
  if (sofa_.taps == 0 || sofa_.taps > kMostTaps) {
    refuse("N", fmt::format("expected 1 to {} taps, found {}", kMostTaps, sofa_.taps));
  }
}

const SofaVariable& Reader::variable(std::string_view name, std::size_t one,
                                     std::size_t all) const {
  const auto found = sofa_.variables.find(name);
  const std::size_t count = found == sofa_.variables.end() ? 0 : found->second.values.size();
  if (count != one && count != all) {
    refuse(name, fmt::format("expected {}{} numbers, found {}", one,
                             one == all ? "" : fmt::format(" or {}", all), count));
  }
  for (const float value : found->second.values) {
    if (!std::isfinite(value)) refuse(name, "expected finite numbers, found NaN or infinity");
  }
  return found->second;
}

// "degree, degree, metre" for spherical coordinates, "metre" or three of them for cartesian ones;
// also in the plural, abbreviated or in American spelling. Files without units mean these.
void Reader::check_units(std::string_view field, const SofaVariable& variable,
                         std::string_view type) const {
  if (variable.units.empty()) return;
  const bool spherical = type == "spherical";
  std::vector<std::string> units(1);
  for (const char c : variable.units) {
    if (c == ',') {
      units.emplace_back();
    } else if (c != ' ') {
      units.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  const auto is_metre = [](const std::string& unit) {
    return unit == "metre" || unit == "meter" || unit == "metres" || unit == "meters" ||
           unit == "m";
  };
  const auto is_degree = [](const std::string& unit) {
    return unit == "degree" || unit == "degrees" || unit == "deg";
  };
  bool right = spherical ? units.size() == 3 : units.size() == 1 || units.size() == 3;
  for (std::size_t i = 0; right && i < units.size(); ++i) {
    right = spherical && i < 2 ? is_degree(units[i]) : is_metre(units[i]);
  }
  if (right) return;
  refuse(field, fmt::format("expected units of {}, found '{}'",
                            spherical ? "degree, degree, metre" : "metre", variable.units));
}

Vector3 Reader::coordinates(std::string_view field, const SofaVariable& variable,
                            std::string_view type, std::size_t index) const {
  if (index == 0) check_units(field, variable, type);
  const float* values = variable.values.data() + (variable.values.size() == 3 ? 0 : 3 * index);
  if (type == "cartesian") return {values[0], values[1], values[2]};
  if (type == "spherical") {
    return cartesian_from_spherical(
        {radians_from_degrees(values[0]), radians_from_degrees(values[1]), values[2]});
  }
  refuse(field, fmt::format("expected the type cartesian or spherical, found '{}'", type));
}

std::array<int, 2> Reader::receivers_left_right() const {
  // Stored [receiver][coordinate][I or M]; the ears do not move, so the first of each will do.
  const SofaVariable& stored = variable("ReceiverPosition", 6, 6 * sofa_.measurements);
  const std::size_t repeats = stored.values.size() / 6;
  std::array<double, 2> y_m{};
  for (std::size_t receiver = 0; receiver < 2; ++receiver) {
    SofaVariable place{.values = {}, .type = stored.type, .units = stored.units};
    for (std::size_t c = 0; c < 3; ++c) {
      place.values.push_back(stored.values[(receiver * 3 + c) * repeats]);
    }
    y_m[receiver] = coordinates("ReceiverPosition", place, stored.type, 0).y;
  }
  if (y_m[0] > 0.0 && y_m[1] < 0.0) return {0, 1};
  if (y_m[0] < 0.0 && y_m[1] > 0.0) return {1, 0};
  refuse("ReceiverPosition", fmt::format("expected one ear at positive y (left) and one at "
                                         "negative y, found y = {} and {} m",
                                         y_m[0], y_m[1]));
}

int Reader::sample_rate_hz() const {
  const SofaVariable& stored = variable("Data.SamplingRate", 1, sofa_.measurements);
  const float rate_hz = stored.values[0];
  if (std::ranges::any_of(stored.values, [&](float other) { return other != rate_hz; })) {
    refuse("Data.SamplingRate", "expected one rate, found several");
  }
  if (!(rate_hz >= 8000.0F && rate_hz <= 384000.0F && rate_hz == std::round(rate_hz)) ||
      (!stored.units.empty() && stored.units != "hertz")) {
    refuse("Data.SamplingRate",
           fmt::format("expected a whole number from 8000 to 384000 hertz, found {} {}", rate_hz,
                       stored.units));
  }
  return static_cast<int>(rate_hz);
}

void Reader::read_positions(SofaFile& file) const {
  const std::size_t all = 3 * sofa_.measurements;
  const SofaVariable& sources = variable("SourcePosition", all, all);
  const SofaVariable& listener = variable("ListenerPosition", 3, all);
  const SofaVariable& view = variable("ListenerView", 3, all);
  const SofaVariable& up = variable("ListenerUp", 3, all);
  // ListenerUp has no type of its own: it shares ListenerView's.
  const std::string& up_type = up.type.empty() ? view.type : up.type;
  for (std::size_t m = 0; m < sofa_.measurements; ++m) {
    const Vector3 source = coordinates("SourcePosition", sources, sources.type, m) -
                           coordinates("ListenerPosition", listener, listener.type, m);
    const Vector3 front = coordinates("ListenerView", view, view.type, m);
    const Vector3 left = cross(coordinates("ListenerUp", up, up_type, m), front);
    if (norm(source) < 1e-3) refuse("SourcePosition", "expected it away from the listener");
    if (norm(left) < 1e-3) refuse("ListenerUp", "expected it across ListenerView");
    const Vector3 x = normalized(front);
    const Vector3 y = normalized(left);
    file.positions_m.push_back({dot(source, x), dot(source, y), dot(source, cross(x, y))});
  }
}

void Reader::read_responses(SofaFile& file) const {
  const std::size_t count = 2 * sofa_.measurements;
  const SofaVariable& responses = variable("Data.IR", count * sofa_.taps, count * sofa_.taps);
  const SofaVariable& delays = variable("Data.Delay", 2, count);
  const std::array<int, 2> receivers = receivers_left_right();
  file.responses.resize(responses.values.size());
  file.delays_samples.resize(sofa_.measurements);
  for (std::size_t m = 0; m < sofa_.measurements; ++m) {
    for (int ear = 0; ear < 2; ++ear) {
      const std::size_t from = 2 * m + receivers[ear];
      std::ranges::copy(
          std::span(responses.values).subspan(from * sofa_.taps, sofa_.taps),
          file.responses.begin() + static_cast<std::ptrdiff_t>((2 * m + ear) * sofa_.taps));
      const double delay = delays.values[delays.values.size() == 2 ? receivers[ear] : from];
      if (!(delay >= 0.0 && delay <= static_cast<double>(kMostTaps))) {
        refuse("Data.Delay", fmt::format("expected 0 to {} samples, found {}", kMostTaps, delay));
      }
      file.delays_samples[m][ear] = delay;
      if (std::ranges::all_of(file.response(m, ear), [](float tap) { return tap == 0.0F; })) {
        refuse("Data.IR", fmt::format("measurement {} has only zeros for the {} ear", m + 1,
                                      ear == 0 ? "left" : "right"));
      }
    }
  }
}

// The head shadows the far ear, whatever the set; files with swapped ears do exist.
void Reader::check_left_is_left(const SofaFile& file) const {
  double near = 0.0;
  double far = 0.0;
  for (std::size_t m = 0; m < file.positions_m.size(); ++m) {
    const double lateral = file.positions_m[m].y / norm(file.positions_m[m]);
    if (std::abs(lateral) < 0.5) continue;
    for (int ear = 0; ear < 2; ++ear) {
      double energy = 0.0;
      for (const float tap : file.response(m, ear)) energy += static_cast<double>(tap) * tap;
      ((lateral > 0.0) == (ear == 0) ? near : far) += energy;
    }
  }
  if (near < far) {
    refuse("Data.IR",
           "expected sources on the left to be louder at the left ear, found the "
           "opposite: the ears or the azimuths are swapped");
  }
}

SofaFile Reader::read() const {
  check_convention();
  SofaFile file;
  file.sample_rate_hz = sample_rate_hz();
  file.taps = static_cast<int>(sofa_.taps);
  read_positions(file);
  read_responses(file);
  check_left_is_left(file);
  return file;
}

void check_signature(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const auto starts_with = [&](std::string_view magic) {
    return bytes.size() >= magic.size() &&
           std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
  };
  if (starts_with("\x89HDF\r\n\x1a\n")) return;
  const bool classic = starts_with("CDF\x01") || starts_with("CDF\x02") || starts_with("CDF\x05");
  throw InputError(path.string(),
                   fmt::format("expected a SOFA file (NetCDF-4), found {}",
                               classic ? "classic NetCDF" : "something else"),
                   classic ? "convert it: nccopy -k nc4" : kHint);
}

}  // namespace

SofaFile sofa_file_from_contents(const std::filesystem::path& path, const SofaContents& contents) {
  return Reader(path, contents).read();
}

SofaFile read_sofa(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path);
  check_signature(path, bytes);
  return sofa_file_from_contents(path, load_sofa_contents(bytes, path.string()));
}

std::filesystem::path default_hrtf_path() {
  if (const char* named = std::getenv("EARPOINT_HRTF"); named != nullptr && *named != '\0') {
    return named;
  }
  const char* listed = std::getenv("XDG_DATA_DIRS");
  std::string folders = listed == nullptr ? "" : listed;
  folders += ":/usr/local/share:/usr/share";
  std::size_t begin = 0;
  while (begin <= folders.size()) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    std::filesystem::path path =
        std::filesystem::path(folders.substr(begin, end - begin)) / kDefaultSet;
    std::error_code ignored;
    if (end > begin && std::filesystem::is_regular_file(path, ignored)) return path;
    begin = end + 1;
  }
  throw InputError(std::string(kDefaultSet),
                   "the default set of head-related impulse responses is not installed",
                   "install the Debian package libmysofa1 or set EARPOINT_HRTF to a SOFA file");
}

}  // namespace earpoint
