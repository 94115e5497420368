#include <earpoint/dataset/rwavs.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/axes.h>
#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/dataset/sample.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPositions = "position.json";
constexpr const char* kDrySound = "source_syn_re.wav";
constexpr const char* kHeardSound = "binaural_syn_re.wav";
constexpr int kRate_hz = 16000;

fs::path poses_file(const fs::path& scene, const std::string& split) {
  return scene / fmt::format("transforms_scale_{}.json", split);
}

/// The second of a frame: "frames/00012.png" is of second 12.
int second_of(const JsonField& field) {
  const std::string stem = fs::path(field.text()).stem().string();
  int second = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), second);
  if (error != std::errc() || end != stem.data() + stem.size() || second < 0) {
    field.fail("a frame named by its second, such as frames/00012.png");
  }
  return second;
}

/// A camera of nerfstudio: sixteen numbers in rows, x right, y up, z backwards; world z up.
Pose pose_of(const JsonField& field) {
  const std::vector<JsonField> items = field.items();
  if (items.size() != 16) field.fail("16 numbers, the rows of a 4 x 4 matrix");
  std::array<double, 16> m{};
  for (std::size_t i = 0; i < m.size(); ++i) {
    m[i] = items[i].number();
    if (!std::isfinite(m[i])) items[i].fail("a finite number");
  }
  const Vector3 right{m[0], m[4], m[8]};
  const Vector3 up{m[1], m[5], m[9]};
  const Vector3 back{m[2], m[6], m[10]};
  constexpr double kRounding = 1e-3;
  for (const Vector3& axis : {right, up, back}) {
    if (std::abs(norm(axis) - 1.0) > kRounding) field.fail("a rotation");
  }
  if (std::abs(dot(right, up)) > kRounding || norm(cross(right, up) - back) > 2.0 * kRounding) {
    field.fail("a rotation");
  }
  return {{m[3], m[7], m[11]}, quaternion_from_axes(-1.0 * back, -1.0 * right, up)};
}

std::vector<RwavsMoment> read_moments(const fs::path& scene, const std::string& split) {
  const fs::path file = poses_file(scene, split);
  const nlohmann::json json = read_json(file);
  std::vector<RwavsMoment> moments;
  for (const JsonField& item : JsonField(json, file.string()).field("camera_path").items()) {
    const JsonField frame = item.field("file_path");
    moments.push_back({scene.filename().string(), frame.text(), second_of(frame),
                       pose_of(item.field("camera_to_world"))});
  }
  if (moments.empty()) throw InputError(file.string(), "has no poses");
  return moments;
}

Waveform read_channels(const fs::path& file, int channels) {
  Waveform sound = read_sound(stored_input(file));
  if (sound.channels() != channels) {
    throw InputError(file.string(),
                     fmt::format("has {} channels, expected {}", sound.channels(), channels));
  }
  if (!std::ranges::all_of(sound.planar(), [](float x) { return std::isfinite(x); })) {
    throw InputError(file.string(), "holds NaN or infinite samples", "write the file again");
  }
  return resample(sound, kRate_hz);
}

/// The second around a moment, as the released loader cuts it: one that begins before the sound has
/// the sound from its start, and zeros follow where it ends.
Waveform second_around(const Waveform& sound, int time_s) {
  const std::ptrdiff_t start = std::ptrdiff_t{time_s} * kRate_hz - kPairSamples / 2;
  Waveform result(sound.channels(), kPairSamples, kRate_hz);
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, start);
  const std::ptrdiff_t last = std::min(sound.samples(), start + kPairSamples);
  for (int c = 0; c < sound.channels() && first < last; ++c) {
    std::ranges::copy(sound.channel(c).subspan(first, last - first), result.channel(c).begin());
  }
  return result;
}

double energy_of(const Waveform& sound) {
  double sum = 0.0;
  for (int c = 0; c < sound.channels(); ++c) sum += energy(sound.channel(c));
  return sum / sound.channels();
}

}  // namespace

/// The sounds of a scene at 16 kHz, the dry one scaled.
struct RwavsDataset::Sounds {
  Waveform dry;
  Waveform heard;
};

struct RwavsDataset::Cache {
  std::mutex mutex;
  std::string scene;
  std::shared_ptr<const Sounds> sounds;
};

std::optional<fs::path> rwavs_root(const fs::path& folder) {
  const auto is_scene = [](const fs::path& path) {
    return fs::exists(poses_file(path, "train")) || fs::exists(poses_file(path, "val"));
  };
  if (fs::exists(folder / kPositions)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (is_scene(entry.path())) return folder;
    }
  }
  fs::path here = fs::absolute(folder).lexically_normal();
  if (!here.has_filename()) here = here.parent_path();
  if (is_scene(here) && fs::exists(here.parent_path() / kPositions)) return here.parent_path();
  return std::nullopt;
}

RwavsDataset::RwavsDataset(Options options)
    : options_(std::move(options)), cache_(std::make_shared<Cache>()) {
  if (options_.split != "train" && options_.split != "val") {
    throw InputError("split", fmt::format("RWAVS has train and val, found {}", options_.split));
  }
  const fs::path file = options_.root / kPositions;
  const nlohmann::json json = read_json(file);
  std::vector<std::pair<std::string, Vector3>> found;
  for (const auto& [name, field] : JsonField(json, file.string()).fields()) {
    if (options_.scene && *options_.scene != name) continue;
    if (!fs::is_directory(options_.root / name)) continue;
    found.emplace_back(name, field.field("source_position").vector3());
  }
  // Scenes are numbers: 2 before 10.
  std::ranges::sort(found, [](const auto& a, const auto& b) {
    return std::pair(a.first.size(), a.first) < std::pair(b.first.size(), b.first);
  });
  for (const auto& [name, position] : found) read_scene(name, position);
  if (moments_.empty()) {
    throw InputError(options_.root.string(),
                     fmt::format("has no scene of {}{}", kPositions,
                                 options_.scene ? " named " + *options_.scene : std::string()));
  }
}

void RwavsDataset::read_scene(const std::string& name, const Vector3& position) {
  const fs::path folder = options_.root / name;
  const std::vector<RwavsMoment> training = read_moments(folder, "train");
  double sum = 0.0;
  for (const RwavsMoment& moment : training) {
    sum += norm(moment.world_from_listener.position_m - position);
    training_times_s_[name].push_back(moment.time_s);
  }
  const double mean = sum / static_cast<double>(training.size());
  if (mean <= 0.0) {
    throw InputError(poses_file(folder, "train").string(), "every pose is at the loudspeaker");
  }
  RwavsScene& scene = scenes_[name];
  scene.metres_per_unit = kRwavsMeanDistance_m / mean;
  scene.speaker_m = scene.metres_per_unit * position;

  const SoundInfo info = probe_sound(folder / kHeardSound);
  const double duration_s = static_cast<double>(info.frames) / info.sample_rate_hz;
  for (RwavsMoment& moment :
       options_.split == "train" ? std::vector(training) : read_moments(folder, options_.split)) {
    if (moment.time_s > duration_s) continue;  // less than half a second of its own
    moment.world_from_listener.position_m =
        scene.metres_per_unit * moment.world_from_listener.position_m;
    moments_.push_back(std::move(moment));
  }
}

const RwavsScene& RwavsDataset::scene(const std::string& name) const { return scenes_.at(name); }

std::shared_ptr<const RwavsDataset::Sounds> RwavsDataset::sounds_of(
    const std::string& scene) const {
  const std::lock_guard lock(cache_->mutex);
  if (cache_->scene == scene) return cache_->sounds;
  const fs::path folder = options_.root / scene;
  auto sounds = std::make_shared<Sounds>(
      Sounds{read_channels(folder / kDrySound, 1), read_channels(folder / kHeardSound, 2)});
  double played = 0.0;
  double heard = 0.0;
  for (const int time_s : training_times_s_.at(scene)) {
    played += energy_of(second_around(sounds->dry, time_s));
    heard += energy_of(second_around(sounds->heard, time_s));
  }
  if (!(played > 0.0)) {
    throw InputError((folder / kDrySound).string(), "is silent throughout the training split");
  }
  const auto gain = static_cast<float>(std::sqrt(heard / played));
  for (float& x : sounds->dry.planar()) x *= gain;
  cache_->scene = scene;
  cache_->sounds = sounds;
  return sounds;
}

PairSample RwavsDataset::sample(const RwavsMoment& moment) const {
  const std::shared_ptr<const Sounds> sounds = sounds_of(moment.scene);
  const RwavsScene& scene = scenes_.at(moment.scene);
  PairSample sample;
  sample.dry = second_around(sounds->dry, moment.time_s);
  sample.target = second_around(sounds->heard, moment.time_s);
  sample.source = Waveform(2, kPairSamples, kRate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    std::ranges::copy(std::as_const(sample.dry).channel(0), sample.source.channel(ear).begin());
  }
  sample.world_from_source =
      look_at(scene.speaker_m + Vector3{kRwavsMeanDistance_m, 0.0, 0.0}, scene.speaker_m);
  sample.source_from_target = inverse(sample.world_from_source) * moment.world_from_listener;
  sample.speaker_m = {kRwavsMeanDistance_m, 0.0, 0.0};
  return sample;
}

}  // namespace earpoint
