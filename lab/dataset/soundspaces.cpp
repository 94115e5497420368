#include <earpoint/dataset/soundspaces.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 16000;
constexpr std::ptrdiff_t kSamples = 16000;
constexpr int kImageSize = 256;
constexpr double kCutoff_hz = 80.0;
// The high-pass reflects 33 samples at either end.
constexpr std::ptrdiff_t kFewestSpeechSamples = 34;
// Below this a response counts as silence and keeps its delay, as in the released loader.
constexpr float kSilence = 1e-8F;

/// Number of samples before the first non-zero one in either ear.
std::ptrdiff_t delay_of(const Waveform& response, const std::string& where) {
  const auto samples = response.planar();
  if (std::all_of(samples.begin(), samples.end(),
                  [](float sample) { return std::abs(sample) <= kSilence; })) {
    return 0;
  }
  std::ptrdiff_t first = response.samples();
  for (int ear = 0; ear < response.channels(); ++ear) {
    const auto channel = response.channel(ear);
    const auto onset =
        std::find_if(channel.begin(), channel.end(), [](float sample) { return sample != 0.0F; });
    if (onset == channel.end()) {
      throw InputError(where, fmt::format("channel {} is silent, the other is not", ear));
    }
    first = std::min(first, onset - channel.begin());
  }
  return first;
}

Waveform heard(const Waveform& speech, const Waveform& response) {
  Waveform sound(2, speech.samples() + response.samples() - 1, kRate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<float> convolved = convolve(speech.channel(0), response.channel(ear));
    std::copy(convolved.begin(), convolved.end(), sound.channel(ear).begin());
  }
  return sound;
}

ImagePlanes read_rgb(const fs::path& path) {
  ImagePlanes planes = planes_of(read_image(path));
  for (float& value : planes.values) value /= 255.0F;
  return resize_bilinear(planes, kImageSize, kImageSize);
}

double wrapped(double angle_rad) {
  const double turn = 2.0 * kPi;
  const double rest = std::fmod(angle_rad, turn);
  return rest < 0.0 ? rest + turn : rest;
}

}  // namespace

SoundSpacesDataset::SoundSpacesDataset(Options options) : options_(std::move(options)) {
  const fs::path folder = options_.root / options_.folder / options_.split;
  if (!fs::is_directory(folder)) throw InputError(folder.string(), "no such folder");
  std::vector<fs::path> scenes;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (fs::exists(entry.path() / options_.metadata_file)) scenes.push_back(entry.path());
  }
  std::sort(scenes.begin(), scenes.end());
  if (scenes.empty()) {
    throw InputError(folder.string(), "holds no scene with a " + options_.metadata_file);
  }
  for (const fs::path& scene : scenes) {
    const fs::path path = scene / options_.metadata_file;
    std::vector<SoundSpacesClip> clips =
        parse_soundspaces_metadata(read_text_file(path), path.string(), scene.filename().string());
    std::move(clips.begin(), clips.end(), std::back_inserter(clips_));
  }
}

SoundSpacesChoice SoundSpacesDataset::draw(const SoundSpacesClip& clip, NumpyRandom& random) const {
  SoundSpacesChoice choice;
  if (clip.viewpoints.size() < 2) {
    throw InputError(fmt::format("{}, clip {}", clip.scene, clip.index),
                     "fewer than two viewpoints");
  }
  const std::vector<int> order = random.permutation(static_cast<int>(clip.viewpoints.size()));
  choice.source = order[0];
  choice.target = order[1];
  std::vector<int> speaking;
  for (std::size_t i = 0; i < clip.speakers.size(); ++i) {
    if (clip.speakers[i].speech) speaking.push_back(static_cast<int>(i));
  }
  if (speaking.empty()) {
    throw InputError(fmt::format("{}, clip {}", clip.scene, clip.index), "nobody has speech");
  }
  choice.speaker = speaking[random.index(static_cast<std::uint32_t>(speaking.size()))];
  if (options_.split == "train") {
    const std::ptrdiff_t length = read_speech(*clip.speakers[choice.speaker].speech).samples();
    if (length > kSamples) {
      choice.window_start = random.index(static_cast<std::uint32_t>(length - kSamples));
    }
  }
  return choice;
}

fs::path SoundSpacesDataset::speech_path(const std::string& speech) const {
  return options_.root / options_.speech_folder / soundspaces_speech_file(options_.split, speech);
}

Waveform SoundSpacesDataset::read_speech(const std::string& speech) const {
  const fs::path path = speech_path(speech);
  Waveform sound = read_sound(path);
  if (sound.channels() != 1) {
    throw InputError(path.string(), fmt::format("expected 1 channel, found {}", sound.channels()));
  }
  if (sound.samples() < kFewestSpeechSamples) {
    throw InputError(path.string(), fmt::format("expected speech of {} samples or more, found {}",
                                                kFewestSpeechSamples, sound.samples()));
  }
  if (probe_sound(path).is_pcm16) {
    // The released loader does not scale integers.
    for (float& sample : sound.planar()) sample *= 32768.0F;
  }
  return resample_sinc(highpass(sound, kCutoff_hz), kRate_hz);
}

std::ptrdiff_t SoundSpacesDataset::speech_samples(const std::string& speech) const {
  const SoundInfo info = probe_sound(speech_path(speech));
  return static_cast<std::ptrdiff_t>(info.frames * kRate_hz / info.sample_rate_hz);
}

SoundSpacesDataset::Response SoundSpacesDataset::read_response(const std::string& rir) const {
  const fs::path path = path_of(rir);
  Waveform response = read_sound(path);
  if (response.channels() != 2) {
    throw InputError(path.string(),
                     fmt::format("expected 2 channels, found {}", response.channels()));
  }
  response = resample_sinc(response, kRate_hz);
  const std::ptrdiff_t delay = delay_of(response, path.string());
  return {window_of(response, delay, response.samples() - delay), delay};
}

NvasSample SoundSpacesDataset::sample(const SoundSpacesClip& clip,
                                      const SoundSpacesChoice& choice) const {
  const SoundSpacesViewpoint& source = clip.viewpoints.at(choice.source);
  const SoundSpacesViewpoint& target = clip.viewpoints.at(choice.target);
  const SoundSpacesSpeaker& speaker = clip.speakers.at(choice.speaker);
  const std::string where = fmt::format("{}, clip {}", clip.scene, clip.index);
  EARPOINT_CHECK(speaker.speech.has_value());
  if (!source.rir.contains(speaker.id) || !target.rir.contains(speaker.id) ||
      !source.bboxes.contains(speaker.id)) {
    throw InputError(where, fmt::format("speaker {} has no response or box", speaker.id));
  }

  NvasSample sample;
  const Waveform speech = read_speech(*speaker.speech);
  sample.source = window_of(heard(speech, read_response(source.rir.at(speaker.id)).sound),
                            choice.window_start, kSamples);
  sample.target = window_of(heard(speech, read_response(target.rir.at(speaker.id)).sound),
                            choice.window_start, kSamples);
  sample.source_rgb = read_rgb(path_of(source.image));
  sample.target_rgb = read_rgb(path_of(target.image));
  for (const int edge : source.bboxes.at(speaker.id)) sample.bboxes.push_back(edge / 255.0);
  const auto pose = soundspaces_pose(source, target.location);
  const auto rotation = soundspaces_rotation(source, target);
  sample.tgt_pose.assign(pose.begin(), pose.end());
  sample.tgt_rotation.assign(rotation.begin(), rotation.end());
  return sample;
}

std::array<double, 3> soundspaces_pose(const SoundSpacesViewpoint& from, const Vector3& to) {
  const double dx = to.x - from.location.x;
  const double dz = to.z - from.location.z;
  const double theta_rad = std::atan2(dz, dx);
  const double azimuth_rad = wrapped(1.5 * kPi - theta_rad - from.rotation_rad);
  return {std::hypot(dx, dz), std::sin(azimuth_rad), std::cos(azimuth_rad)};
}

std::array<double, 2> soundspaces_rotation(const SoundSpacesViewpoint& from,
                                           const SoundSpacesViewpoint& to) {
  const double turn_rad = wrapped(to.rotation_rad - from.rotation_rad);
  return {std::sin(turn_rad), std::cos(turn_rad)};
}

}  // namespace earpoint
