#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/evaluate/evaluation_set.h>

namespace earpoint {
namespace {

constexpr double kMetresPerCentimetre = 0.01;
// The one worker of the released evaluation's loader seeds its generator with its number.
constexpr std::uint32_t kReleasedSeed = 0;

Image image_of(const ImagePlanes& planes) {
  Image image(planes.width, planes.height, planes.channels);
  std::size_t i = 0;
  for (int channel = 0; channel < planes.channels; ++channel) {
    for (int y = 0; y < planes.height; ++y) {
      for (int x = 0; x < planes.width; ++x) {
        const float value = std::clamp(255.0F * planes.values[i++], 0.0F, 255.0F);
        image.at(x, y, channel) = static_cast<std::uint8_t>(std::lround(value));
      }
    }
  }
  return image;
}

/// Their world has z up, as ours; only the unit differs.
Pose world_from(const ReplayCamera& camera) {
  const Vector3 centre_m = camera.centre * kMetresPerCentimetre;
  return look_at(centre_m, centre_m + camera.direction);
}

class ReplayEvaluationSet : public EvaluationSet {
 public:
  ReplayEvaluationSet(const std::filesystem::path& root, const std::string& split,
                      std::optional<std::size_t> limit)
      : dataset_(options_of(root, split)) {
    NumpyRandom random(kReleasedSeed);
    std::map<std::string, int> sessions;
    std::vector<Entry> all;
    for (const ReplayClip& clip : dataset_.clips()) {
      const auto session =
          sessions.try_emplace(clip.scene, static_cast<int>(sessions.size())).first->second;
      all.push_back({&clip, dataset_.draw(clip, random), session});
    }
    const std::size_t count = std::min(limit.value_or(all.size()), all.size());
    for (std::size_t i = 0; i < count; ++i) pairs_.push_back(all[i * all.size() / count]);
  }

  [[nodiscard]] std::size_t size() const override { return pairs_.size(); }
  [[nodiscard]] std::string name(std::size_t pair) const override {
    const Entry& entry = pairs_.at(pair);
    return fmt::format("{}: {} -> {}", entry.clip->folder, entry.clip->images[entry.choice.source],
                       entry.clip->images[entry.choice.target]);
  }
  [[nodiscard]] std::string scene(std::size_t pair) const override {
    return pairs_.at(pair).clip->scene;
  }
  [[nodiscard]] int cluster(std::size_t pair) const override { return pairs_.at(pair).session; }
  [[nodiscard]] bool knows_speaker() const override { return false; }
  [[nodiscard]] PairSample sample(std::size_t pair) const override { return sample(pair, false); }
  [[nodiscard]] std::optional<PairTruth> truth(std::size_t /*pair*/) const override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<PairSample> released_sample(std::size_t pair) const override {
    return sample(pair, true);
  }

 private:
  struct Entry {
    const ReplayClip* clip = nullptr;
    ReplayChoice choice;
    int session = 0;
  };

  static ReplayDataset::Options options_of(const std::filesystem::path& root,
                                           const std::string& split) {
    ReplayDataset::Options options;
    options.root = root;
    options.split = split;
    return options;
  }

  [[nodiscard]] PairSample sample(std::size_t pair, bool align) const {
    const auto& [clip, choice, session] = pairs_.at(pair);
    NvasSample loaded = dataset_.sample(*clip, choice, align);
    PairSample sample;
    sample.world_from_source =
        world_from(dataset_.camera(clip->scene, clip->images[choice.source]));
    const Pose world_from_target =
        world_from(dataset_.camera(clip->scene, clip->images[choice.target]));
    sample.source_from_target = inverse(sample.world_from_source) * world_from_target;
    sample.picture = std::make_shared<const Image>(image_of(loaded.source_rgb));
    const std::vector<double>& box = loaded.bboxes;
    sample.speaker_box = Box{.x_min = box[0], .y_min = box[1], .x_max = box[2], .y_max = box[3]};
    sample.source = std::move(loaded.source);
    sample.target = std::move(loaded.target);
    return sample;
  }

  ReplayDataset dataset_;
  std::vector<Entry> pairs_;
};

}  // namespace

bool is_replay_folder(const std::filesystem::path& folder) {
  const ReplayDataset::Options options;
  return std::filesystem::exists(folder / options.folder / options.metadata_file);
}

std::unique_ptr<EvaluationSet> replay_evaluation_set(const std::filesystem::path& root,
                                                     const std::string& split,
                                                     std::optional<std::size_t> limit) {
  return std::make_unique<ReplayEvaluationSet>(root, split, limit);
}

}  // namespace earpoint
