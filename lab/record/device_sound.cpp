#include <earpoint/record/device_sound.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/resample.h>
#include <earpoint/error.h>
#include <earpoint/media/media.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kBlockSamples = 48000;
constexpr float kSilence = 1e-5F;  // -100 dB: below the noise of any microphone and of 16 bits

/// Collects blocks and joins them, channel by channel.
class Recorder {
 public:
  explicit Recorder(int channels) : channels_(static_cast<std::size_t>(channels)) {}

  void add(const Waveform& block) {
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      const auto samples = block.channel(static_cast<int>(c));
      channels_[c].insert(channels_[c].end(), samples.begin(), samples.end());
    }
  }

  [[nodiscard]] Waveform sound() const {
    Waveform sound(static_cast<int>(channels_.size()), std::ssize(channels_.front()), kSyncRateHz);
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      std::ranges::copy(channels_[c], sound.channel(static_cast<int>(c)).begin());
    }
    return sound;
  }

 private:
  std::vector<std::vector<float>> channels_;
};

void replace_what_is_not_finite(Waveform& block) {
  for (float& x : block.planar()) {
    if (!std::isfinite(x)) x = 0.0F;
  }
}

/// Reads to the end, or to where the file is damaged, which a note reports.
Waveform read_at_sync_rate(AudioReader& reader, int channels, const std::string& who,
                           std::vector<std::string>& notes) {
  StreamResampler resampler(channels, reader.sample_rate_hz(), kSyncRateHz);
  Recorder recorder(channels);
  std::int64_t read = 0;
  std::optional<std::string> damage;
  while (true) {
    Waveform both;
    try {
      both = reader.read(kBlockSamples);
    } catch (const InputError& error) {
      damage = error.what();
      both = Waveform(2, 0, reader.sample_rate_hz());
    }
    read += both.samples();
    replace_what_is_not_finite(both);
    Waveform block(channels, both.samples(), reader.sample_rate_hz());
    std::copy_n(both.planar().begin(), block.planar().size(), block.planar().begin());
    const bool last = both.samples() < kBlockSamples;
    recorder.add(resampler.process(block, last));
    if (last) break;
  }
  const double read_s = static_cast<double>(read) / reader.sample_rate_hz();
  if (damage) notes.push_back(fmt::format("{}: {}; used up to {:.1f} s", who, *damage, read_s));
  const std::optional<double> stated_s = reader.duration_s();
  constexpr double kMissing_s = 1.0;
  if (!damage && stated_s && *stated_s > read_s + kMissing_s) {
    notes.push_back(
        fmt::format("{}: its sound ends at {:.1f} s of {:.1f} s", who, read_s, *stated_s));
  }
  for (const std::string& warning : reader.warnings()) {
    notes.push_back(fmt::format("{}: {}", who, warning));
  }
  return recorder.sound();
}

bool is_silent(const Waveform& sound) {
  return std::ranges::all_of(sound.planar(), [](float x) { return std::abs(x) < kSilence; });
}

/// Adds the device, or a note with the reason why it cannot be used.
void add_device(DeviceSound device, const std::filesystem::path& path, DeviceSounds& sounds) {
  const std::string who = (device.is_camera ? "camera " : "near microphone of ") + device.name;
  try {
    // A near microphone is the first channel of its file.
    AudioReader reader(path,
                       device.is_camera ? std::nullopt : std::optional(std::array<int, 2>{0, 0}));
    device.sound = read_at_sync_rate(reader, device.is_camera ? 2 : 1, who, sounds.notes);
  } catch (const InputError& error) {
    sounds.notes.push_back(fmt::format("{} is left out: {}", who, error.what()));
    return;
  }
  if (is_silent(device.sound)) {
    sounds.notes.push_back(fmt::format("{} is left out: {} is silent", who, path.string()));
    return;
  }
  sounds.devices.push_back(std::move(device));
}

}  // namespace

DeviceSounds read_device_sounds(const Session& session, ProgressSink& progress) {
  DeviceSounds sounds;
  progress.begin("reading sounds",
                 static_cast<double>(session.cameras.size() + session.people.size()), "devices");
  for (const SessionCamera& camera : session.cameras) {
    add_device({.name = camera.name,
                .is_camera = true,
                .world_from_head = camera.world_from_camera,
                .near_distance_m = 0.0,
                .sound = {}},
               camera.video, sounds);
    progress.advance(1.0);
  }
  const auto cameras = std::ssize(sounds.devices);
  if (cameras < 2) {
    throw InputError(session.file.string(),
                     sounds.notes.empty() ? "has fewer than two cameras" : sounds.notes.front(),
                     "at least two cameras with binaural sound are needed");
  }
  for (const SessionPerson& person : session.people) {
    add_device({.name = person.name,
                .is_camera = false,
                .world_from_head = {},
                .near_distance_m = person.near_distance_m,
                .sound = {}},
               person.near, sounds);
    progress.advance(1.0);
  }
  progress.finish();
  return sounds;
}

}  // namespace earpoint
