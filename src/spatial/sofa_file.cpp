#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <mysofa.h>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/core/pose.h>
#include <earpoint/spatial/sofa_file.h>

namespace earpoint {
namespace {

constexpr std::string_view kConvention = "SimpleFreeFieldHRIR";
constexpr std::string_view kDefaultSet = "libmysofa/MIT_KEMAR_normal_pinna.sofa";
constexpr std::string_view kMend = "give another set of head-related impulse responses";

using SofaHandle = std::unique_ptr<MYSOFA_HRTF, decltype(&mysofa_free)>;

// One file being read; every refusal names it.
class Reader {
 public:
  Reader(const std::filesystem::path& path, const MYSOFA_HRTF& sofa) : path_(path), sofa_(sofa) {}

  SofaFile read() const;

 private:
  [[noreturn]] void refuse(std::string_view field, const std::string& problem) const {
    throw InputError(fmt::format("{}: {}", path_.string(), field), problem, kMend);
  }
  void check_convention() const;
  void check_values(std::string_view field, const MYSOFA_ARRAY& array, std::size_t one,
                    std::size_t all) const;
  std::string attribute(MYSOFA_ATTRIBUTE* attributes, std::string_view name) const;
  Vector3 coordinates(std::string_view field, const MYSOFA_ARRAY& array, std::size_t index) const;
  std::array<int, 2> receivers_left_right() const;
  int sample_rate_hz() const;
  void read_positions(SofaFile& file) const;
  void read_responses(SofaFile& file) const;
  void check_left_is_left(const SofaFile& file) const;

  const std::filesystem::path& path_;
  const MYSOFA_HRTF& sofa_;
};

std::string Reader::attribute(MYSOFA_ATTRIBUTE* attributes, std::string_view name) const {
  for (const MYSOFA_ATTRIBUTE* entry = attributes; entry != nullptr; entry = entry->next) {
    if (entry->name != nullptr && name == entry->name) {
      return entry->value == nullptr ? "" : entry->value;
    }
  }
  return "";
}

void Reader::check_convention() const {
  const std::string convention = attribute(sofa_.attributes, "SOFAConventions");
  if (convention != kConvention) {
    refuse("SOFAConventions", fmt::format("expected {}, found '{}'", kConvention, convention));
  }
  const std::string type = attribute(sofa_.attributes, "DataType");
  if (type != "FIR") refuse("DataType", fmt::format("expected FIR, found '{}'", type));
  if (sofa_.R != 2) refuse("R", fmt::format("expected 2 receivers, found {}", sofa_.R));
  if (sofa_.M == 0 || sofa_.N == 0) {
    refuse("Data.IR", fmt::format("expected measurements, found {} of {} taps", sofa_.M, sofa_.N));
  }
  constexpr unsigned kMostTaps = 1U << 16U;
  if (sofa_.N > kMostTaps) {
    refuse("N", fmt::format("expected at most {} taps, found {}", kMostTaps, sofa_.N));
  }
}

// A field holds `one` value set for all measurements or a set for each: `all` values.
void Reader::check_values(std::string_view field, const MYSOFA_ARRAY& array, std::size_t one,
                          std::size_t all) const {
  if (array.values == nullptr || (array.elements != one && array.elements != all)) {
    refuse(field, fmt::format("expected {}{} numbers, found {}", one,
                              one == all ? "" : fmt::format(" or {}", all),
                              array.values == nullptr ? 0 : array.elements));
  }
  for (std::size_t i = 0; i < array.elements; ++i) {
    if (!std::isfinite(array.values[i])) refuse(field, "expected finite numbers, found NaN or inf");
  }
}

Vector3 Reader::coordinates(std::string_view field, const MYSOFA_ARRAY& array,
                            std::size_t index) const {
  const float* values = array.values + (array.elements == 3 ? 0 : 3 * index);
  const std::string type = attribute(array.attributes, "Type");
  if (type == "cartesian") return {values[0], values[1], values[2]};
  if (type == "spherical") {
    return cartesian_from_spherical(
        {radians_from_degrees(values[0]), radians_from_degrees(values[1]), values[2]});
  }
  refuse(field, fmt::format("expected the type cartesian or spherical, found '{}'", type));
}

std::array<int, 2> Reader::receivers_left_right() const {
  // Stored [receiver][coordinate][I or M]; the ears do not move, so the first of each will do.
  const MYSOFA_ARRAY& array = sofa_.ReceiverPosition;
  check_values("ReceiverPosition", array, 6, std::size_t{6} * sofa_.M);
  const std::size_t repeats = array.elements / 6;
  const bool spherical = attribute(array.attributes, "Type") == "spherical";
  std::array<double, 2> y_m{};
  for (int receiver = 0; receiver < 2; ++receiver) {
    const auto value = [&](int c) { return array.values[(receiver * 3 + c) * repeats]; };
    y_m[receiver] = spherical ? cartesian_from_spherical({radians_from_degrees(value(0)),
                                                          radians_from_degrees(value(1)), value(2)})
                                    .y
                              : value(1);
  }
  if (y_m[0] > 0.0 && y_m[1] < 0.0) return {0, 1};
  if (y_m[0] < 0.0 && y_m[1] > 0.0) return {1, 0};
  refuse("ReceiverPosition", fmt::format("expected one ear at positive y (left) and one at "
                                         "negative y, found y = {} and {} m",
                                         y_m[0], y_m[1]));
}

int Reader::sample_rate_hz() const {
  check_values("Data.SamplingRate", sofa_.DataSamplingRate, 1, sofa_.M);
  const float rate_hz = sofa_.DataSamplingRate.values[0];
  for (unsigned i = 1; i < sofa_.DataSamplingRate.elements; ++i) {
    if (sofa_.DataSamplingRate.values[i] != rate_hz) {
      refuse("Data.SamplingRate", "expected one rate, found several");
    }
  }
  const std::string units = attribute(sofa_.DataSamplingRate.attributes, "Units");
  if (!(rate_hz >= 8000.0F && rate_hz <= 384000.0F && rate_hz == std::round(rate_hz)) ||
      (!units.empty() && units != "hertz")) {
    refuse("Data.SamplingRate", fmt::format("expected a whole number from 8000 to 384000 hertz, "
                                            "found {} {}",
                                            rate_hz, units));
  }
  return static_cast<int>(rate_hz);
}

void Reader::read_positions(SofaFile& file) const {
  check_values("SourcePosition", sofa_.SourcePosition, std::size_t{3} * sofa_.M,
               std::size_t{3} * sofa_.M);
  for (const auto& [field, array] : {std::pair{"ListenerPosition", &sofa_.ListenerPosition},
                                     std::pair{"ListenerView", &sofa_.ListenerView},
                                     std::pair{"ListenerUp", &sofa_.ListenerUp}}) {
    check_values(field, *array, 3, std::size_t{3} * sofa_.M);
  }
  // ListenerUp has no type of its own: it shares ListenerView's.
  MYSOFA_ARRAY up_array = sofa_.ListenerUp;
  if (attribute(up_array.attributes, "Type").empty()) {
    up_array.attributes = sofa_.ListenerView.attributes;
  }
  for (unsigned m = 0; m < sofa_.M; ++m) {
    const Vector3 source = coordinates("SourcePosition", sofa_.SourcePosition, m) -
                           coordinates("ListenerPosition", sofa_.ListenerPosition, m);
    const Vector3 view = coordinates("ListenerView", sofa_.ListenerView, m);
    const Vector3 left = cross(coordinates("ListenerView", up_array, m), view);
    if (norm(source) < 1e-3) refuse("SourcePosition", "expected it away from the listener");
    if (norm(left) < 1e-3) refuse("ListenerUp", "expected it across ListenerView");
    const Vector3 x = normalized(view);
    const Vector3 y = normalized(left);
    file.positions_m.push_back({dot(source, x), dot(source, y), dot(source, cross(x, y))});
  }
}

void Reader::read_responses(SofaFile& file) const {
  const std::size_t values = std::size_t{2} * sofa_.M * sofa_.N;
  check_values("Data.IR", sofa_.DataIR, values, values);
  check_values("Data.Delay", sofa_.DataDelay, 2, std::size_t{2} * sofa_.M);
  const std::array<int, 2> receivers = receivers_left_right();
  file.responses.resize(values);
  file.delays_samples.resize(sofa_.M);
  for (unsigned m = 0; m < sofa_.M; ++m) {
    for (int ear = 0; ear < 2; ++ear) {
      const std::size_t from = std::size_t{2} * m + receivers[ear];
      std::copy_n(sofa_.DataIR.values + from * sofa_.N, sofa_.N,
                  file.responses.begin() + (std::ptrdiff_t{2} * m + ear) * sofa_.N);
      const std::size_t delay = sofa_.DataDelay.elements == 2 ? receivers[ear] : from;
      file.delays_samples[m][ear] = sofa_.DataDelay.values[delay];
      if (!(file.delays_samples[m][ear] >= 0.0 &&
            file.delays_samples[m][ear] < sofa_.N + 65536.0)) {
        refuse("Data.Delay",
               fmt::format("expected samples from 0 on, found {}", file.delays_samples[m][ear]));
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
  file.taps = static_cast<int>(sofa_.N);
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
                   classic ? "convert it: nccopy -k nc4" : kMend);
}

}  // namespace

SofaFile read_sofa(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path);
  check_signature(path, bytes);
  int error = MYSOFA_OK;
  const SofaHandle sofa(
      mysofa_load_data(reinterpret_cast<const char*>(bytes.data()), bytes.size(), &error),
      &mysofa_free);
  if (sofa == nullptr) {
    throw InputError(path.string(),
                     fmt::format("the SOFA file is damaged or of a kind that "
                                 "libmysofa cannot read (code {})",
                                 error),
                     kMend);
  }
  return Reader(path, *sofa).read();
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
    const std::filesystem::path path =
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
