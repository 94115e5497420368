#include <earpoint/record/prepare.h>

#include "prepared_scene.h"
#include "seen_people.h"
#include "sliding_sound.h"
#include "speech_windows.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/atomic_folder.h>
#include <earpoint/core/file.h>
#include <earpoint/core/resize.h>
#include <earpoint/dataset/npy.h>
#include <earpoint/dataset/replay_splits.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/record/aligned_sound.h>
#include <earpoint/record/device_sound.h>
#include <earpoint/record/session_sync.h>
#include <earpoint/record/sync.h>
#include <earpoint/record/sync_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kAlignedRate_hz = 48000;
constexpr int kClipRate_hz = 16000;
constexpr double kWindow_s = 1.0;
constexpr std::ptrdiff_t kWindowSamples = kClipRate_hz;
constexpr int kMostWidth_px = 1280;
constexpr int kMostHeight_px = 720;
constexpr int kBoxesPerWindow = 5;

/// A camera that is used for clips.
struct UsedCamera {
  std::size_t index = 0;  ///< in the session
  int number = 0;         ///< number in its file names
  DeviceClock clock;
  double begin_s = 0.0;  ///< of its recording, in session time
  double end_s = 0.0;
};

/// A near microphone that can be used.
struct UsedMicrophone {
  std::size_t index = 0;  ///< of the person in the session
  DeviceClock clock;
  double end_s = 0.0;
};

/// The names, if all are numbers; otherwise cameras are counted from 1.
std::vector<int> camera_numbers(const Session& session) {
  std::vector<int> numbers;
  for (const SessionCamera& camera : session.cameras) {
    int number = 0;
    const char* end = camera.name.data() + camera.name.size();
    const auto parsed = std::from_chars(camera.name.data(), end, number);
    if (parsed.ec != std::errc() || parsed.ptr != end || number < 1 ||
        camera.name != std::to_string(number)) {
      numbers.clear();
      for (std::size_t c = 0; c < session.cameras.size(); ++c) {
        numbers.push_back(static_cast<int>(c) + 1);
      }
      return numbers;
    }
    numbers.push_back(number);
  }
  return numbers;
}

std::string split_of(const Session& session, const PrepareOptions& options) {
  if (options.split) return *options.split;
  if (session.split) return *session.split;
  for (const char* split : {"test", "val"}) {
    const auto scenes = replay_scenes(split);
    if (std::ranges::find(scenes, session.scene) != scenes.end()) return split;
  }
  return "train";
}

/// The picture, scaled down to at most the size of the published ones.
Image shrunk(const Image& image) {
  const double scale = std::min({1.0, static_cast<double>(kMostWidth_px) / image.width(),
                                 static_cast<double>(kMostHeight_px) / image.height()});
  if (scale == 1.0) return image;
  const ImagePlanes planes =
      resize_bilinear(planes_of(image), static_cast<int>(std::lround(scale * image.width())),
                      static_cast<int>(std::lround(scale * image.height())));
  Image result(planes.width, planes.height, planes.channels);
  std::size_t i = 0;
  for (int c = 0; c < planes.channels; ++c) {
    for (int y = 0; y < planes.height; ++y) {
      for (int x = 0; x < planes.width; ++x) {
        result.at(x, y, c) =
            static_cast<std::uint8_t>(std::lround(std::clamp(planes.values[i++], 0.0F, 255.0F)));
      }
    }
  }
  return result;
}

/// Whether the sound has a stretch of zeros that fills a gap of the recording.
bool has_gap(const Waveform& sound) {
  constexpr float kNothing = 1e-6F;
  constexpr int kShortest = kClipRate_hz / 20;
  int silent = 0;
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    bool nothing = true;
    for (int c = 0; c < sound.channels(); ++c) {
      nothing = nothing && std::abs(sound.channel(c)[i]) < kNothing;
    }
    silent = nothing ? silent + 1 : 0;
    if (silent >= kShortest) return true;
  }
  return false;
}

NearLevel near_level(const Waveform& sound) {
  double sum = 1e-12;
  float peak = 1e-6F;
  for (const float x : sound.channel(0)) {
    sum += static_cast<double>(x) * x;
    peak = std::max(peak, std::abs(x));
  }
  return {static_cast<float>(10.0 * std::log10(sum / static_cast<double>(sound.samples()))),
          20.0F * std::log10(peak)};
}

class Preparation {
 public:
  Preparation(const Session& session, const PrepareOptions& options, ProgressSink& progress)
      : session_(session),
        options_(options),
        progress_(progress),
        folder_(prepared_folder(options.out) / session.scene) {
    summary_.scene = session.scene;
    summary_.split = split_of(session, options);
  }

  PrepareSummary run() {
    claim_folder();
    synchronize_devices();
    people_ = std::make_unique<SeenPeople>(session_, sync_);
    choose_devices();
    align_sounds();
    const std::vector<SpeechWindow> windows = judge();
    make_clips(windows);
    std::vector<PreparedCamera> cameras;
    for (const UsedCamera& camera : cameras_) {
      const SessionCamera& recorded = session_.cameras[camera.index];
      PreparedCamera& prepared = cameras.emplace_back();
      prepared.number = camera.number;
      prepared.world_from_camera = *recorded.world_from_camera;
      if (const std::optional<Lens>& lens = recorded.lens) {
        prepared.horizontal_fov_rad = 2.0 * std::atan(0.5 * lens->width_px / lens->fx_px);
      }
    }
    write_scene(folder_, summary_.split, cameras, clips_);
    write_dataset_files(options_.out);
    return std::move(summary_);
  }

 private:
  /// Reserves the scene's folder for one session description and one hop.
  void claim_folder() {
    create_folder(folder_ / "aligned");
    const std::string text =
        fmt::format("{}\nhop_s {}\n", read_text_file(session_.file), options_.hop_s);
    const fs::path record = folder_ / "session.txt";
    if (!fs::exists(record)) {
      write_file(record, std::string_view(text));
    } else if (read_text_file(record) != text) {
      throw InputError(folder_.string(), "was prepared from another session description",
                       "remove it, or choose another folder or scene");
    }
  }

  void synchronize_devices() {
    const fs::path stored = folder_ / "sync.json";
    if (!fs::exists(stored)) {
      const DeviceSounds sounds = read_device_sounds(session_, progress_);
      const SyncResult found = synchronize_session(session_, sounds, progress_);
      write_file(stored, std::string_view(json_of(found)));
    }
    sync_ = read_sync(stored);
    summary_.notes = sync_.notes;
  }

  void choose_devices() {
    const std::vector<int> numbers = camera_numbers(session_);
    for (std::size_t c = 0; c < session_.cameras.size(); ++c) {
      const SessionCamera& camera = session_.cameras[c];
      const SyncedDevice* device = sync_.find(camera.name);
      if (device == nullptr) continue;  // its note has the reason
      if (!camera.world_from_camera) {
        summary_.notes.push_back(fmt::format(
            "camera {} is left out: it is not calibrated; give its extrinsics", camera.name));
        continue;
      }
      cameras_.push_back({c, numbers[c], device->clock, session_time_s(device->clock, 0.0),
                          session_time_s(device->clock, device->duration_s)});
    }
    if (cameras_.size() < 2) {
      throw InputError(session_.file.string(),
                       "fewer than two cameras are calibrated and synchronised",
                       "clips need two views");
    }
    for (std::size_t p = 0; p < session_.people.size(); ++p) {
      const SyncedDevice* device = sync_.find(session_.people[p].name);
      if (device == nullptr) continue;
      microphones_.push_back({p, device->clock, session_time_s(device->clock, device->duration_s)});
    }
    if (microphones_.empty()) {
      throw InputError(session_.file.string() + ".people", "no near microphone can be used",
                       "they show who speaks when");
    }
    begin_s_ = cameras_.front().begin_s;
    end_s_ = cameras_.front().end_s;
    for (const UsedCamera& camera : cameras_) {
      begin_s_ = std::min(begin_s_, camera.begin_s);
      end_s_ = std::max(end_s_, camera.end_s);
    }
    summary_.cameras = static_cast<int>(cameras_.size());
    summary_.windows = std::max(
        0, static_cast<int>(std::floor((end_s_ - begin_s_ - kWindow_s) / options_.hop_s)) + 1);
  }

  [[nodiscard]] fs::path aligned(const std::string& device) const {
    return folder_ / "aligned" / (device + ".flac");
  }

  /// Writes every device on session time at 48 kHz, from begin_s_ on.
  void align_sounds() {
    progress_.begin("aligning sounds", static_cast<double>(cameras_.size() + microphones_.size()),
                    "devices");
    for (const UsedCamera& camera : cameras_) {
      align(session_.cameras[camera.index].video, 2, camera.clock);
    }
    for (const UsedMicrophone& microphone : microphones_) {
      align(session_.people[microphone.index].near, 1, microphone.clock);
    }
    progress_.finish();
  }

  void align(const fs::path& media, int channels, const DeviceClock& clock) {
    const fs::path path = aligned(clock.name);
    if (!fs::exists(path)) {
      AlignedSound sound(media, channels, clock, begin_s_, kAlignedRate_hz);
      SoundWriter writer(path, channels, kAlignedRate_hz);
      auto left = static_cast<std::ptrdiff_t>((end_s_ - begin_s_) * kAlignedRate_hz);
      while (left > 0) {
        const std::ptrdiff_t block = std::min(left, std::ptrdiff_t{kAlignedRate_hz});
        writer.write(sound.read(block));
        left -= block;
      }
      writer.close();
    }
    progress_.advance(1.0);
  }

  [[nodiscard]] std::ptrdiff_t window_begin(std::size_t window) const {
    return std::lround(static_cast<double>(window) * options_.hop_s * kClipRate_hz);
  }
  [[nodiscard]] double window_time_s(std::size_t window) const {
    return begin_s_ + static_cast<double>(window_begin(window)) / kClipRate_hz;
  }

  std::vector<SpeechWindow> judge() {
    std::vector<std::vector<NearLevel>> levels;
    for (const UsedMicrophone& microphone : microphones_) {
      SlidingSound sound(aligned(microphone.clock.name), kClipRate_hz);
      auto& own = levels.emplace_back();
      for (int w = 0; w < summary_.windows; ++w) {
        own.push_back(near_level(sound.window(window_begin(w), kWindowSamples)));
      }
    }
    return judge_windows(levels);
  }

  void make_clips(const std::vector<SpeechWindow>& windows) {
    std::vector<SlidingSound> heard;
    std::vector<std::unique_ptr<FrameReader>> pictures;
    for (const UsedCamera& camera : cameras_) {
      heard.emplace_back(aligned(camera.clock.name), kClipRate_hz);
      pictures.push_back(std::make_unique<FrameReader>(session_.cameras[camera.index].video));
    }
    std::vector<SlidingSound> near;
    for (const UsedMicrophone& microphone : microphones_) {
      near.emplace_back(aligned(microphone.clock.name), kClipRate_hz);
    }
    progress_.begin("making clips", static_cast<double>(windows.size()), "windows");
    for (std::size_t w = 0; w < windows.size(); ++w) {
      progress_.advance(1.0);
      const SpeechWindow& window = windows[w];
      if (window.kind == WindowKind::silent) ++summary_.silent;
      if (window.kind == WindowKind::noisy) ++summary_.noisy;
      if (window.kind != WindowKind::speech) continue;
      const fs::path place = folder_ / std::to_string(w);
      std::optional<PreparedClip> clip = stored_clip(place);
      if (!clip) {
        clip =
            make_clip(w, window, heard, near[static_cast<std::size_t>(window.speaker)], pictures);
        if (!clip) continue;
        ++summary_.made;
      }
      ++summary_.clips;
      if (clip->overlapping) ++summary_.overlapping;
      clips_.push_back(std::move(*clip));
    }
    progress_.finish();
    if (clips_.empty()) {
      throw InputError(session_.file.string(), "it has no second with speech in two cameras");
    }
  }

  /// @return nothing if fewer than two cameras recorded that second
  std::optional<PreparedClip> make_clip(std::size_t w, const SpeechWindow& window,
                                        std::vector<SlidingSound>& heard, SlidingSound& near,
                                        std::vector<std::unique_ptr<FrameReader>>& pictures) {
    const std::size_t microphone = microphones_[static_cast<std::size_t>(window.speaker)].index;
    const std::size_t speaker = people_->wearers()[microphone];
    const double middle_s = window_time_s(w) + 0.5 * kWindow_s;
    PreparedClip clip{.window = static_cast<int>(w),
                      .time_s = window_time_s(w),
                      .speaker = session_.people[speaker].name,
                      .overlapping = window.overlapping,
                      .mouth_m = people_->mouth(microphone, middle_s),
                      .images = {}};
    AtomicFolder folder(folder_ / std::to_string(w));
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      const UsedCamera& camera = cameras_[c];
      if (clip.time_s < camera.begin_s || clip.time_s + kWindow_s > camera.end_s) continue;
      const Waveform sound = heard[c].window(window_begin(w), kWindowSamples);
      if (has_gap(sound)) continue;
      const std::optional<Image> picture = picture_at(*pictures[c], camera, middle_s);
      if (!picture) continue;
      const fs::path stem = folder.aside() / std::to_string(camera.number);
      write_image(stem.string() + ".png", *picture);
      write_sound(stem.string() + ".wav", sound);
      write_npy(stem.string() + ".npy", boxes(microphone, camera.index, clip.time_s, speaker));
      clip.images.push_back(fmt::format("{}.png", camera.number));
    }
    if (clip.images.size() < 2) return std::nullopt;
    write_sound(folder.aside() / "near.wav", near.window(window_begin(w), kWindowSamples));
    write_file(folder.aside() / "clip.json", json_of(clip));
    folder.commit();
    return clip;
  }

  /// @return nothing where the camera's movie is damaged, with one note
  std::optional<Image> picture_at(FrameReader& reader, const UsedCamera& camera, double time_s) {
    try {
      return shrunk(reader.frame_nearest(device_time_s(camera.clock, time_s)));
    } catch (const InputError& error) {
      if (damaged_.insert(camera.number).second) summary_.notes.emplace_back(error.what());
      return std::nullopt;
    }
  }

  /// Rows of x_min, y_min, x_max, y_max, id of the speaker, five a second; zeros if out of sight.
  [[nodiscard]] NumberTable boxes(std::size_t microphone, std::size_t camera, double begin_s,
                                  std::size_t speaker) const {
    NumberTable table{.rows = kBoxesPerWindow, .columns = 5, .values = {}};
    for (int row = 0; row < kBoxesPerWindow; ++row) {
      const double time_s = begin_s + (row + 0.5) / kBoxesPerWindow;
      const Box box = people_->box(microphone, camera, time_s).value_or(Box{});
      const auto id = static_cast<double>(speaker + 1);
      table.values.insert(table.values.end(), {box.x_min, box.y_min, box.x_max, box.y_max, id});
    }
    return table;
  }

  const Session& session_;
  const PrepareOptions& options_;
  ProgressSink& progress_;
  fs::path folder_;
  SyncResult sync_;
  std::unique_ptr<SeenPeople> people_;
  std::vector<UsedCamera> cameras_;
  std::vector<UsedMicrophone> microphones_;
  double begin_s_ = 0.0;
  double end_s_ = 0.0;
  std::vector<PreparedClip> clips_;
  std::set<int> damaged_;
  PrepareSummary summary_;
};

}  // namespace

PrepareSummary prepare_session(const Session& session, const PrepareOptions& options,
                               ProgressSink& progress) {
  EARPOINT_CHECK(options.hop_s > 0.0);
  return Preparation(session, options, progress).run();
}

}  // namespace earpoint
