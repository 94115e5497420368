#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/evaluate/evaluation_set.h>

namespace earpoint {
namespace {

class ReplayEvaluationSet : public EvaluationSet {
 public:
  ReplayEvaluationSet(const std::filesystem::path& folder, const std::string& split,
                      std::optional<std::size_t> limit, PairTarget target)
      : dataset_(replay_options(folder, split)), sampler_(dataset_, 0), target_(target) {
    const std::vector<ReplayChoice> choices = dataset_.released_choices();
    std::map<std::string, int> sessions;
    std::vector<Entry> all;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      const ReplayClip& clip = dataset_.clips()[i];
      const auto session =
          sessions.try_emplace(clip.scene, static_cast<int>(sessions.size())).first->second;
      all.push_back({&clip, choices[i], session});
    }
    const std::size_t count = std::min(limit.value_or(all.size()), all.size());
    for (std::size_t i = 0; i < count; ++i) pairs_.push_back(all[i * all.size() / count]);
  }

  [[nodiscard]] std::size_t size() const override { return pairs_.size(); }
  [[nodiscard]] std::string name(std::size_t pair) const override {
    const Entry& entry = pairs_.at(pair);
    std::string source =
        fmt::format("{}: {}", entry.clip->folder, entry.clip->images[entry.choice.source]);
    if (target_ == PairTarget::near_microphone) return source;
    return fmt::format("{} -> {}", source, entry.clip->images[entry.choice.target]);
  }
  [[nodiscard]] std::string scene(std::size_t pair) const override {
    return pairs_.at(pair).clip->scene;
  }
  [[nodiscard]] int cluster(std::size_t pair) const override { return pairs_.at(pair).session; }
  [[nodiscard]] std::string pairs() const override { return "drawn as the released test does"; }
  [[nodiscard]] bool knows_speaker() const override {
    return std::ranges::all_of(pairs_,
                               [](const Entry& entry) { return entry.clip->mouth_m.has_value(); });
  }
  [[nodiscard]] PairSample sample(std::size_t pair) const override { return sample(pair, false); }
  [[nodiscard]] std::optional<PairTruth> truth(std::size_t /*pair*/) const override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<PairSample> released_sample(std::size_t pair) const override {
    if (target_ == PairTarget::near_microphone) return std::nullopt;
    return sample(pair, true);
  }

 private:
  struct Entry {
    const ReplayClip* clip = nullptr;
    ReplayChoice choice;
    int session = 0;
  };

  [[nodiscard]] PairSample sample(std::size_t pair, bool align) const {
    const Entry& entry = pairs_.at(pair);
    if (target_ == PairTarget::near_microphone) {
      return sampler_.enhancement_sample(*entry.clip, entry.choice.source);
    }
    return sampler_.sample(*entry.clip, entry.choice, align);
  }

  ReplayDataset dataset_;
  ReplaySampler sampler_;
  PairTarget target_;
  std::vector<Entry> pairs_;
};

}  // namespace

std::unique_ptr<EvaluationSet> replay_evaluation_set(const std::filesystem::path& folder,
                                                     const std::string& split,
                                                     std::optional<std::size_t> limit,
                                                     PairTarget target) {
  return std::make_unique<ReplayEvaluationSet>(folder, split, limit, target);
}

}  // namespace earpoint
