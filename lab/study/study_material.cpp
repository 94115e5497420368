#include <earpoint/study/study_material.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/dataset/numpy_random.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 16000;
constexpr std::size_t kCacheBytes = std::size_t{64} << 20U;
constexpr std::uint32_t kReleasedSeed = 0;

class SoundSpacesMaterial : public StudyMaterial {
 public:
  SoundSpacesMaterial(const fs::path& folder, const std::string& split,
                      const std::optional<fs::path>& list, double duration_s)
      : dataset_(soundspaces_options(folder, split)),
        sampler_(dataset_, kCacheBytes),
        samples_(std::lround(duration_s * kRate_hz)) {
    const std::optional<fs::path> found = list ? list : find_pair_list(folder, split);
    PairList pairs = list ? read_pair_list(*list) : frozen_or_drawn_pairs(dataset_, folder);
    where_ = found ? found->filename().string() : "drawn, every viewpoint the target once";
    if (pairs.split != split) {
      throw InputError(found->string(),
                       fmt::format("is of the split {}, expected {}", pairs.split, split));
    }
    std::map<std::pair<std::string, int>, int> conversations;
    for (ViewPair& pair : pairs.pairs) {
      const auto known = conversations.try_emplace({pair.scene, pair.clip},
                                                   static_cast<int>(conversations.size()));
      const SoundSpacesClip& clip = clip_of(pair, dataset_.clips(), where_);
      pairs_.push_back({std::move(pair), &clip, known.first->second});
    }
    if (pairs_.empty()) throw InputError(where_, "holds no pairs");
  }

  [[nodiscard]] std::size_t size() const override { return pairs_.size(); }
  [[nodiscard]] std::string name(std::size_t pair) const override {
    const ViewPair& view = pairs_.at(pair).pair;
    return fmt::format("{}, clip {}: {} -> {}, speaker {}, at {:.2f} s", view.scene, view.clip,
                       view.choice.source, view.choice.target, view.choice.speaker,
                       static_cast<double>(view.choice.window_start) / kRate_hz);
  }
  [[nodiscard]] std::string scene(std::size_t pair) const override {
    return pairs_.at(pair).pair.scene;
  }
  [[nodiscard]] int conversation(std::size_t pair) const override {
    return pairs_.at(pair).conversation;
  }
  [[nodiscard]] std::string pairs() const override { return where_; }
  [[nodiscard]] std::optional<PairSample> sample(std::size_t pair) const override {
    const Entry& entry = pairs_.at(pair);
    SoundSpacesChoice choice = entry.pair.choice;
    const std::ptrdiff_t last =
        sampler_.speech_samples(entry.clip->speakers[choice.speaker]) - samples_;
    if (last < 0) return std::nullopt;
    choice.window_start = std::min(choice.window_start, last);
    return sampler_.sample(*entry.clip, choice, samples_);
  }
  [[nodiscard]] std::shared_ptr<const Image> target_picture(std::size_t pair) const override {
    const Entry& entry = pairs_.at(pair);
    return sampler_.picture(*entry.clip, entry.pair.choice.target);
  }
  [[nodiscard]] bool knows_speaker() const override { return true; }

 private:
  struct Entry {
    ViewPair pair;
    const SoundSpacesClip* clip;
    int conversation;
  };
  SoundSpacesDataset dataset_;
  PairSampler sampler_;
  std::ptrdiff_t samples_;
  std::string where_;
  std::vector<Entry> pairs_;
};

class ReplayMaterial : public StudyMaterial {
 public:
  ReplayMaterial(const fs::path& folder, const std::string& split, double duration_s)
      : dataset_(replay_options(folder, split)), samples_(std::lround(duration_s * kRate_hz)) {
    NumpyRandom random(kReleasedSeed);
    std::map<std::string, int> sessions;
    for (const ReplayClip& clip : dataset_.clips()) {
      const int session =
          sessions.try_emplace(clip.scene, static_cast<int>(sessions.size())).first->second;
      pairs_.push_back({&clip, dataset_.draw(clip, random), session});
    }
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
  /// Every clip is another second; what clips share is the scene, that is, the session.
  [[nodiscard]] int conversation(std::size_t pair) const override { return static_cast<int>(pair); }
  [[nodiscard]] std::string pairs() const override { return "drawn as the released test does"; }
  [[nodiscard]] std::optional<PairSample> sample(std::size_t pair) const override {
    const Entry& entry = pairs_.at(pair);
    PairSample sample = replay_pair(dataset_, *entry.clip, entry.choice, false);
    if (sample.target.samples() < samples_) return std::nullopt;
    return sample;
  }
  [[nodiscard]] std::shared_ptr<const Image> target_picture(std::size_t pair) const override {
    const Entry& entry = pairs_.at(pair);
    const ReplayChoice back{.source = entry.choice.target, .target = entry.choice.source};
    return replay_pair(dataset_, *entry.clip, back, false).picture;
  }
  [[nodiscard]] bool knows_speaker() const override {
    return std::ranges::all_of(pairs_,
                               [](const Entry& entry) { return entry.clip->mouth_m.has_value(); });
  }

 private:
  struct Entry {
    const ReplayClip* clip;
    ReplayChoice choice;
    int session;
  };
  ReplayDataset dataset_;
  std::ptrdiff_t samples_;
  std::vector<Entry> pairs_;
};

}  // namespace

std::unique_ptr<StudyMaterial> study_material(const fs::path& folder, DatasetLayout layout,
                                              const std::string& split,
                                              const std::optional<fs::path>& list,
                                              double duration_s) {
  EARPOINT_CHECK(duration_s > 0.0);
  if (layout == DatasetLayout::soundspaces) {
    return std::make_unique<SoundSpacesMaterial>(folder, split, list, duration_s);
  }
  if (list) {
    throw InputError("pairs", "Replay-NVAS has no pair lists; its pairs are drawn", "leave it out");
  }
  if (duration_s > 1.0) {
    throw InputError("seconds", "clips of Replay-NVAS last one second", "use 1");
  }
  return std::make_unique<ReplayMaterial>(folder, split, duration_s);
}

}  // namespace earpoint
