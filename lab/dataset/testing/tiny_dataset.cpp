#include <earpoint/dataset_testing/tiny_dataset.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/media/image_file.h>
#include <earpoint/plot/draw.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRateHz = 16000;
constexpr int kPictureSize = 64;
constexpr double kSpeedOfSoundMps = 343.0;

/// Noise in bursts, like syllables.
Waveform speech(double duration_s, RandomStream& random) {
  Waveform sound(1, std::lround(duration_s * kRateHz), kRateHz);
  const double syllables_hz = random.uniform(3.0, 6.0);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const double time_s = static_cast<double>(i) / kRateHz;
    const double loudness = std::max(0.1, std::sin(2.0 * kPi * syllables_hz * time_s));
    sound.channel(0)[i] = static_cast<float>(0.2 * loudness * random.uniform(-1.0, 1.0));
  }
  return sound;
}

Waveform response(const Vector3& speaker_m, double duration_s, RandomStream& random) {
  Waveform sound(2, std::lround(duration_s * kRateHz), kRateHz);
  const Spherical seen = spherical_from_cartesian(speaker_m);
  const auto delay = static_cast<std::ptrdiff_t>(seen.distance_m / kSpeedOfSoundMps * kRateHz);
  for (int ear = 0; ear < 2; ++ear) {
    const double towards = (ear == 0 ? 1.0 : -1.0) * std::sin(seen.azimuth_rad);
    const auto samples = sound.channel(ear);
    samples[delay] = static_cast<float>((1.0 + 0.6 * towards) / seen.distance_m);
    for (std::ptrdiff_t i = delay + 1; i < sound.samples(); ++i) {
      const double decay = std::exp(-6.9 * static_cast<double>(i - delay) / (0.1 * kRateHz));
      samples[i] = static_cast<float>(0.03 * decay * random.normal());
    }
  }
  return sound;
}

class Writer {
 public:
  Writer(const fs::path& folder, const TinyDataset& options)
      : folder_(folder), options_(options), random_(options.seed) {}

  void write_split(const std::string& split) {
    std::vector<SoundSpacesClip> clips;
    clips.reserve(static_cast<std::size_t>(options_.clips));
    for (int i = 0; i < options_.clips; ++i) clips.push_back(make_clip(split, i));
    write_file(folder_ / split / "room" / kSoundSpacesMetadata, soundspaces_metadata(clips));
    const auto length = [&](const std::string&) {
      return std::lround(options_.speech_s * kRateHz);
    };
    write_file(folder_ / fmt::format("pairs-{}.json", split),
               text_of(draw_pair_list(split, clips, length, options_.seed)));
  }

 private:
  SoundSpacesSpeaker make_speaker(const std::string& split, int clip, int id) {
    SoundSpacesSpeaker speaker{.id = id,
                               .speech = fmt::format("{}-{}-0", id, clip),
                               .location = to_soundspaces({0.0, id == 0 ? 0.6 : -0.6, 1.5})};
    speaker.rotation_rad = id == 0 ? 1.5 * kPi : 0.5 * kPi;
    const fs::path path = folder_ / "speech" / soundspaces_speech_file(split, *speaker.speech);
    fs::create_directories(path.parent_path());
    write_sound(path, speech(options_.speech_s, random_));
    return speaker;
  }

  SoundSpacesClip make_clip(const std::string& split, int index) {
    SoundSpacesClip clip{.scene = "room", .index = index, .viewpoints = {}, .speakers = {}};
    for (int id = 0; id < 2; ++id) clip.speakers.push_back(make_speaker(split, index, id));
    for (int v = 0; v < options_.viewpoints; ++v) {
      const double bearing_rad = random_.uniform(-kPi, kPi);
      const Pose pose{{2.0 * std::cos(bearing_rad), 2.0 * std::sin(bearing_rad), 1.5},
                      quaternion_from_euler({.yaw_rad = random_.uniform(-kPi, kPi)})};
      clip.viewpoints.push_back(
          make_viewpoint(fmt::format("{}/room/{}/", split, index), v, pose, clip.speakers));
    }
    return clip;
  }

  SoundSpacesViewpoint make_viewpoint(const std::string& place, int index, const Pose& pose,
                                      const std::vector<SoundSpacesSpeaker>& speakers) {
    SoundSpacesViewpoint viewpoint{.location = to_soundspaces(pose.position_m),
                                   .rotation_rad = soundspaces_heading_rad(pose.orientation),
                                   .rir = {},
                                   .image = fmt::format("{}view_{}.png", place, index),
                                   .bboxes = {}};
    fs::create_directories(folder_ / place);
    const auto shade = static_cast<std::uint8_t>(random_.index(256));
    Image picture = filled_image(kPictureSize, kPictureSize, {shade, 90, 60});
    for (const SoundSpacesSpeaker& speaker : speakers) {
      const Vector3 seen = transform_point(inverse(pose), from_soundspaces(speaker.location));
      viewpoint.rir[speaker.id] = fmt::format("{}rir_{}_{}.wav", place, index, speaker.id);
      write_sound(folder_ / viewpoint.rir[speaker.id], response(seen, options_.response_s, random_),
                  SampleFormat::float32);
      std::optional<Box> box;
      if (index != 0 || speaker.id != 1) {
        const double left = random_.uniform(0.0, 0.7);
        box = Box{.x_min = left, .y_min = 0.25, .x_max = left + 0.25, .y_max = 0.75};
        fill_rect(picture, {static_cast<int>(left * kPictureSize), 16, 16, 32}, {20, 200, 40});
      }
      viewpoint.bboxes[speaker.id] = soundspaces_box(box);
    }
    write_image(folder_ / viewpoint.image, picture);
    return viewpoint;
  }

  fs::path folder_;
  TinyDataset options_;
  RandomStream random_;
};

}  // namespace

void write_tiny_dataset(const fs::path& folder, const TinyDataset& options) {
  fs::create_directories(folder);
  write_file(folder / "dataset.json",
             R"({"format": "earpoint-dataset-1", "speech_folder": "speech", "path_prefix": ""})");
  Writer writer(folder, options);
  for (const char* split : {"train", "val", "test"}) {
    fs::create_directories(folder / split / "room");
    writer.write_split(split);
  }
}

void write_published_dataset(const fs::path& folder, const TinyDataset& options, bool pcm16) {
  const fs::path scenes = "data/synthetic_dataset/v16";
  const fs::path plain = folder / "plain";
  write_tiny_dataset(plain, options);
  fs::create_directories(folder / "data/synthetic_dataset");
  fs::remove_all(folder / scenes);
  fs::remove_all(folder / "data/LibriSpeech-wav");
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(plain / "speech")) {
    if (!entry.is_regular_file()) continue;
    // libsndfile reads by the contents; only the writer uses the extension.
    const fs::path wave = entry.path().string() + ".wav";
    write_sound(wave, read_sound(entry.path()),
                pcm16 ? SampleFormat::pcm16 : SampleFormat::float32);
    fs::rename(wave, entry.path());
  }
  fs::rename(plain / "speech", folder / "data/LibriSpeech-wav");
  for (const char* split : {"train", "val", "test"}) {
    fs::remove(plain / fmt::format("pairs-{}.json", split));
    // Published metadata has paths relative to the root.
    const fs::path metadata = plain / split / "room" / kSoundSpacesMetadata;
    std::vector<SoundSpacesClip> clips =
        parse_soundspaces_metadata(read_text_file(metadata), metadata.string(), "room");
    for (SoundSpacesClip& clip : clips) {
      for (SoundSpacesViewpoint& viewpoint : clip.viewpoints) {
        viewpoint.image = (scenes / viewpoint.image).string();
        for (auto& [id, rir] : viewpoint.rir) rir = (scenes / rir).string();
      }
    }
    write_file(metadata, soundspaces_metadata(clips));
  }
  fs::remove(plain / "dataset.json");
  fs::rename(plain, folder / scenes);
}

}  // namespace earpoint
