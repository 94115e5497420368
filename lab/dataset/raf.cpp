#include <earpoint/dataset/raf.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReceiverNumbers = 3;
constexpr std::size_t kSpeakerNumbers = 7;

/// Numbers separated by commas, blanks or new lines.
std::vector<double> read_numbers(const fs::path& path, std::size_t count) {
  const std::string text = read_text_file(path);
  std::vector<double> numbers;
  std::string_view rest = text;
  const auto skip = [&rest] {
    rest.remove_prefix(std::min(rest.find_first_not_of(", \t\r\n"), rest.size()));
  };
  for (skip(); !rest.empty(); skip()) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error != std::errc() || !std::isfinite(value)) {
      throw InputError(path.string(), fmt::format("number {} cannot be read", numbers.size() + 1));
    }
    numbers.push_back(value);
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  }
  if (numbers.size() != count) {
    throw InputError(path.string(),
                     fmt::format("expected {} numbers, found {}", count, numbers.size()));
  }
  return numbers;
}

RafItem read_item(const fs::path& data, const std::string& id) {
  const fs::path folder = data / id;
  if (!fs::is_directory(folder)) throw InputError(folder.string(), "no such folder");
  const fs::path speaker_file = folder / "tx_pos.txt";
  const std::vector<double> receiver = read_numbers(folder / "rx_pos.txt", kReceiverNumbers);
  const std::vector<double> speaker = read_numbers(speaker_file, kSpeakerNumbers);
  RafItem item;
  item.id = id;
  item.receiver_m = position_from_raf({receiver[0], receiver[1], receiver[2]});
  item.world_from_speaker.position_m = position_from_raf({speaker[4], speaker[5], speaker[6]});
  try {
    item.world_from_speaker.orientation = quaternion_from_euler(
        {.yaw_rad = yaw_from_raf(speaker[0], speaker[1], speaker[2], speaker[3])});
  } catch (const InputError& error) {
    throw InputError(speaker_file.string(), error.what());
  }
  return item;
}

/// A folder of a split is a text; published lists hold them flat or in a list of one. read_json()
/// limits the depth.
void add_ids(const JsonField& list, std::vector<std::string>& ids) {
  for (const JsonField& item : list.items()) {
    if (item.is_text()) {
      ids.push_back(item.text());
    } else {
      add_ids(item, ids);
    }
  }
}

std::vector<std::string> ids_in(const fs::path& data) {
  std::vector<std::string> ids;
  for (const fs::directory_entry& entry : fs::directory_iterator(data)) {
    if (entry.is_directory()) ids.push_back(entry.path().filename().string());
  }
  std::ranges::sort(ids);
  return ids;
}

std::vector<std::string> ids_of(const RafDataset::Options& options) {
  if (options.split == "all") return ids_in(options.folder / "data");
  const fs::path file = options.split_file.empty() ? options.folder / "metadata" / "data-split.json"
                                                   : options.split_file;
  if (!fs::exists(file)) {
    throw InputError(file.string(), "no such file",
                     "get the room's list (data-split_emptyroom.json or data-split_furnishedroom."
                     "json of the repository), or use the split all");
  }
  const nlohmann::json json = read_json(file);
  std::vector<std::string> ids;
  add_ids(JsonField(json, file.string()).field(options.split), ids);
  return ids;
}

}  // namespace

Vector3 position_from_raf(const Vector3& raf) { return {raf.z, raf.x, raf.y}; }

double yaw_from_raf(double x, double y, double z, double w) {
  const double scale = x * x + y * y + z * z + w * w;
  if (!(scale > 0.0)) throw InputError("quaternion", "is zero");
  // Adding zero makes -0 to 0, so that an unturned loudspeaker is at 180 degrees, not at -180.
  const double front = -(1.0 - 2.0 * (x * x + y * y) / scale);
  const double left = -2.0 * (x * z + w * y) / scale + 0.0;
  if (std::hypot(front, left) < 1e-6) {
    throw InputError("quaternion", "the loudspeaker faces straight up or down");
  }
  return std::atan2(left, front);
}

RafDataset::RafDataset(Options options) : options_(std::move(options)) {
  const fs::path data = options_.folder / "data";
  if (!fs::is_directory(data)) {
    const bool holds_rooms = fs::is_directory(options_.folder / "EmptyRoom") ||
                             fs::is_directory(options_.folder / "FurnishedRoom");
    throw InputError(options_.folder.string(), "holds no folder data",
                     holds_rooms ? "name one of its rooms, EmptyRoom or FurnishedRoom"
                                 : "name the folder of one room of Real Acoustic Fields");
  }
  for (const std::string& id : ids_of(options_)) items_.push_back(read_item(data, id));
  if (items_.empty()) {
    throw InputError(options_.folder.string(),
                     fmt::format("has no items in the split {}", options_.split));
  }
}

Waveform RafDataset::response(const RafItem& item) const {
  const fs::path file = options_.folder / "data" / item.id / "rir.wav";
  Waveform response = read_sound(stored_input(file));
  if (response.channels() != 1) {
    throw InputError(file.string(),
                     fmt::format("has {} channels, expected 1", response.channels()));
  }
  if (response.samples() == 0) throw InputError(file.string(), "holds no samples");
  return response;
}

const RafItem& nearest_item(const RafItem& item, const std::vector<RafItem>& others) {
  EARPOINT_CHECK(!others.empty());
  const auto yaw = [](const RafItem& x) {
    return euler_from_quaternion(x.world_from_speaker.orientation).yaw_rad;
  };
  const auto distance = [&](const RafItem& other) {
    const double turn = std::remainder(yaw(item) - yaw(other), 2.0 * kPi);
    return norm(item.receiver_m - other.receiver_m) +
           norm(item.world_from_speaker.position_m - other.world_from_speaker.position_m) +
           std::abs(turn);
  };
  return *std::ranges::min_element(others, {}, distance);
}

}  // namespace earpoint
