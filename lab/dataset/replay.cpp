#include <earpoint/dataset/replay.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/gcc_phat.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/dataset/npy.h>
#include <earpoint/dataset/replay_splits.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 16000;
constexpr std::ptrdiff_t kSamples = 16000;
constexpr int kGreatestShift = 200;
constexpr int kImageHeight = 216;
constexpr int kImageWidth = 384;
constexpr std::ptrdiff_t kBlankSamples = 96000;

/// The shipped file holds bare NaN for a camera that could not be placed; JSON has no such word.
std::string without_nan(std::string text) {
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') quoted = !quoted;
    if (!quoted && text.compare(i, 3, "NaN") == 0) text.replace(i, 3, "null");
  }
  return text;
}

/// Numbers in the file may be written as strings.
double loose_number(const JsonField& json) {
  if (!json.is_text()) return json.number();
  const std::string text = json.text();
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw InputError(json.where(), "expected a number, found '" + text + "'");
  }
  return value;
}

Vector3 loose_vector3(const JsonField& json) {
  const std::vector<JsonField> values = json.items();
  if (values.size() != 3) throw InputError(json.where(), "expected three numbers");
  return {loose_number(values[0]), loose_number(values[1]), loose_number(values[2])};
}

/// Radians, by image of the clip; null where they are not known.
std::vector<std::optional<double>> fields_of_view(const JsonField& json, const ReplayClip& clip) {
  std::vector<std::optional<double>> fov_rad;
  for (const JsonField& item : json.items()) {
    if (item.is_null()) {
      fov_rad.emplace_back();
      continue;
    }
    const double fov_deg = item.number();
    if (!(fov_deg > 0.0 && fov_deg < 180.0)) {
      throw InputError(item.where(), fmt::format("expected 0 to 180 degrees, found {:g}", fov_deg));
    }
    fov_rad.emplace_back(radians_from_degrees(fov_deg));
  }
  if (fov_rad.size() != clip.images.size()) {
    throw InputError(json.where(), fmt::format("expected {} numbers, one for each image, found {}",
                                               clip.images.size(), fov_rad.size()));
  }
  return fov_rad;
}

bool has_null(const JsonField& json) {
  const std::vector<JsonField> values = json.items();
  return std::any_of(values.begin(), values.end(), [](const JsonField& v) { return v.is_null(); });
}

nlohmann::json read_with_nan(const fs::path& path) {
  return parse_json(without_nan(read_text_file(path)), path.string());
}

/// The scenes of a split: those of the published data set, unless the folder has a list of its own.
std::set<std::string> scenes_of(const fs::path& splits, const std::string& split) {
  const std::vector<std::string_view> published = replay_scenes(split);
  if (!fs::exists(splits)) return {published.begin(), published.end()};
  const nlohmann::json document = read_with_nan(splits);
  std::set<std::string> scenes;
  for (const JsonField& scene : JsonField(document, splits.string()).field(split).items()) {
    scenes.insert(scene.text());
  }
  return scenes;
}

fs::path beside(fs::path image, const char* extension) {
  return image.replace_extension(extension);
}

/// The picture, or the first frame of the camera's movie if there is no picture file.
Image read_picture(const fs::path& path) {
  const fs::path movie = beside(path, ".mp4");
  if (fs::exists(path) || !fs::exists(movie)) return read_image(path);
  return FrameReader(movie).frame_nearest(0.0);
}

ImagePlanes read_rgb(const fs::path& path) {
  // Unlike the SoundSpaces loader, this one divides after resizing.
  ImagePlanes planes = resize_bilinear(planes_of(read_picture(path)), kImageWidth, kImageHeight);
  for (float& value : planes.values) value /= 255.0F;
  return planes;
}

Waveform read_recording(const fs::path& path) {
  const Waveform sound = read_sound(path);
  if (sound.channels() != 2) {
    throw InputError(path.string(), fmt::format("expected 2 channels, found {}", sound.channels()));
  }
  return highpass(resample_sinc(sound, kRate_hz), kReplayCutoffHz);
}

/// The box of the id that is most frequent in the table of x_min, y_min, x_max, y_max, id.
std::vector<double> read_box(const fs::path& path) {
  const NumberTable table = read_npy(path);
  if (table.columns != 5 || table.rows == 0) {
    throw InputError(path.string(), fmt::format("expected rows of 5 numbers, found {} x {}",
                                                table.rows, table.columns));
  }
  std::map<double, int> counts;
  for (std::size_t row = 0; row < table.rows; ++row) ++counts[table.values[row * 5 + 4]];
  // The map is in ascending order of ids: if counts are equal, the smallest id wins.
  const auto frequent =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  std::size_t row = 0;
  while (table.values[row * 5 + 4] != frequent->first) ++row;
  const auto first = table.values.begin() + static_cast<std::ptrdiff_t>(row * 5);
  return {first, first + 4};
}

std::array<double, 3> angles_of(const Vector3& direction) {
  return {std::atan2(direction.y, direction.x), std::atan2(direction.z, direction.y),
          std::atan2(direction.z, direction.x)};
}

}  // namespace

ReplayCameras read_replay_cameras(const fs::path& path) {
  const nlohmann::json document = read_with_nan(path);
  const JsonField root(document, path.string());
  const JsonField rotations = root.field("rotations");
  ReplayCameras cameras;
  for (const auto& [scene, centres] : root.field("centers").fields()) {
    for (const auto& [camera, centre] : centres.fields()) {
      const JsonField rotation = rotations.field(scene).field(camera);
      // A camera without a position is an error only when it is asked for.
      if (has_null(centre) || has_null(rotation)) continue;
      cameras[scene][camera] = {loose_vector3(centre), loose_vector3(rotation)};
    }
  }
  return cameras;
}

ReplayDataset::ReplayDataset(Options options) : options_(std::move(options)) {
  read_clips();
  read_known();
  cameras_ =
      read_replay_cameras((options_.root / options_.folder).parent_path() / options_.camera_file);
}

void ReplayDataset::read_clips() {
  const fs::path folder = options_.root / options_.folder;
  const std::set<std::string> scenes = scenes_of(folder / options_.splits_file, options_.split);
  const fs::path metadata = folder / options_.metadata_file;
  // Clips keep the order of the file, so the document must be an ordered one.
  const nlohmann::ordered_json ordered =
      parse_ordered_json(without_nan(read_text_file(metadata)), metadata.string());
  if (!ordered.is_object()) throw InputError(metadata.string(), "expected an object of clips");
  for (const auto& [key, value] : ordered.items()) {
    const std::string scene = fs::path(key).parent_path().filename().string();
    if (!scenes.contains(scene)) continue;
    ReplayClip clip{.folder = key, .scene = scene, .images = {}, .mouth_m = {}, .fov_rad = {}};
    const nlohmann::json plain = value;
    for (const JsonField& item : JsonField(plain, metadata.string(), key).items()) {
      clip.images.push_back(item.text());
    }
    if (clip.images.size() < 2) {
      throw InputError(metadata.string() + ": " + key, "fewer than two images");
    }
    clips_.push_back(std::move(clip));
  }
  if (clips_.empty())
    throw InputError(metadata.string(), "holds no clip of the split " + options_.split);
}

void ReplayDataset::read_known() {
  const fs::path path = options_.root / options_.folder / options_.clips_file;
  if (!fs::exists(path)) return;
  const nlohmann::json document = read_with_nan(path);
  const JsonField known(document, path.string());
  for (ReplayClip& clip : clips_) {
    if (!known.has(clip.folder)) continue;
    const JsonField fields = known.field(clip.folder);
    if (fields.has("mouth_m")) clip.mouth_m = fields.field("mouth_m").vector3();
    if (fields.has("fov_deg")) clip.fov_rad = fields_of_view(fields.field("fov_deg"), clip);
  }
}

ReplayChoice ReplayDataset::draw(const ReplayClip& clip, NumpyRandom& random) const {
  const std::vector<int> order = random.permutation(static_cast<int>(clip.images.size()));
  return {order[0], order[1]};
}

ReplayCamera ReplayDataset::camera(const std::string& scene, const std::string& image) const {
  const std::string name = "DSLR-" + fs::path(image).stem().string();
  const auto found = cameras_.find(scene);
  if (found == cameras_.end() || !found->second.contains(name)) {
    throw InputError(options_.camera_file, "has no position of " + name + " in " + scene);
  }
  return found->second.at(name);
}

fs::path ReplayDataset::path_of(const ReplayClip& clip, int view) const {
  return options_.root / clip.folder / clip.images.at(static_cast<std::size_t>(view));
}

ReplayView ReplayDataset::view(const ReplayClip& clip, int view) const {
  const fs::path image = path_of(clip, view);
  try {
    return {read_rgb(image), read_recording(beside(image, ".wav"))};
  } catch (const InputError&) {
    if (!options_.blank_unreadable) throw;
    return {{3, kImageHeight, kImageWidth,
             std::vector<float>(std::size_t{3} * kImageHeight * kImageWidth)},
            Waveform(2, kBlankSamples, kRate_hz)};
  }
}

std::vector<ReplayChoice> ReplayDataset::released_choices() const {
  // The one worker of the released evaluation's loader seeds its generator with its number.
  constexpr std::uint32_t kSeed = 0;
  NumpyRandom random(kSeed);
  std::vector<ReplayChoice> choices;
  choices.reserve(clips_.size());
  for (const ReplayClip& clip : clips_) choices.push_back(draw(clip, random));
  return choices;
}

std::string name_of(const ReplayClip& clip) {
  return clip.scene + "/" + fs::path(clip.folder).filename().string();
}

std::string camera_of(const ReplayClip& clip, int view) {
  return fs::path(clip.images.at(static_cast<std::size_t>(view))).stem().string();
}

std::optional<Waveform> ReplayDataset::near_sound(const ReplayClip& clip) const {
  const fs::path path = options_.root / clip.folder / "near.wav";
  if (!fs::exists(path)) return std::nullopt;
  const Waveform recorded = read_sound(path);
  Waveform first(1, recorded.samples(), recorded.sample_rate_hz());
  std::ranges::copy(recorded.channel(0), first.channel(0).begin());
  return window_of(highpass(resample_sinc(first, kRate_hz), kReplayCutoffHz), 0, kSamples);
}

std::vector<double> ReplayDataset::box(const ReplayClip& clip, int view) const {
  return read_box(beside(path_of(clip, view), ".npy"));
}

NvasSample ReplayDataset::sample(const ReplayClip& clip, const ReplayChoice& choice,
                                 bool align) const {
  NvasSample sample;
  ReplayView source = view(clip, choice.source);
  ReplayView target = view(clip, choice.target);
  if (align) source.sound = aligned_source(source.sound, target.sound);
  sample.source = window_of(source.sound, 0, kSamples);
  sample.target = window_of(target.sound, 0, kSamples);
  sample.source_rgb = std::move(source.rgb);
  sample.target_rgb = std::move(target.rgb);
  sample.bboxes = box(clip, choice.source);

  const ReplayCamera from = camera(clip.scene, clip.images[choice.source]);
  const ReplayCamera to = camera(clip.scene, clip.images[choice.target]);
  const auto pose = replay_pose(from, to);
  const auto rotation = replay_rotation(from, to);
  sample.tgt_pose.assign(pose.begin(), pose.end());
  sample.tgt_rotation.assign(rotation.begin(), rotation.end());
  return sample;
}

Waveform aligned_source(const Waveform& source, const Waveform& target) {
  const double delay = gcc_phat_delay_samples(mean_of_channels(target), mean_of_channels(source));
  return shifted(source, std::clamp(static_cast<int>(delay), -kGreatestShift, kGreatestShift));
}

std::array<double, 3> replay_pose(const ReplayCamera& source, const ReplayCamera& target) {
  const Vector3 offset = target.centre - source.centre;
  const double distance = std::hypot(offset.x, offset.y);
  const double towards_rad = std::atan2(offset.y, offset.x);
  const double turned_rad = 90.0 - (angles_of(source.direction)[0] - towards_rad);
  return {distance * std::cos(turned_rad), distance * std::sin(turned_rad), offset.z};
}

std::array<double, 6> replay_rotation(const ReplayCamera& source, const ReplayCamera& target) {
  const auto from = angles_of(source.direction);
  const auto to = angles_of(target.direction);
  std::array<double, 6> result{};
  for (std::size_t i = 0; i < 3; ++i) {
    result[2 * i] = std::sin(to[i] - from[i]);
    result[2 * i + 1] = std::cos(to[i] - from[i]);
  }
  return result;
}

}  // namespace earpoint
