#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/soundspaces.h>
#include <earpoint/evaluate/evaluation_set.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// `limit` of the pairs, spread evenly over the list, whose neighbours are of one conversation.
std::vector<ViewPair> spread(std::vector<ViewPair> pairs, std::optional<std::size_t> limit) {
  if (!limit || *limit >= pairs.size()) return pairs;
  std::vector<ViewPair> chosen;
  for (std::size_t i = 0; i < *limit; ++i) chosen.push_back(pairs[i * pairs.size() / *limit]);
  return chosen;
}

class SoundSpacesEvaluationSet : public EvaluationSet {
 public:
  SoundSpacesEvaluationSet(const fs::path& folder, const std::string& split,
                           const fs::path& list_path, std::optional<std::size_t> limit,
                           std::size_t cache_bytes, PairTarget target)
      : dataset_(soundspaces_options(folder, split)),
        sampler_(dataset_, cache_bytes, ResponseDelays::dropped, target),
        target_(target) {
    PairList list = read_pair_list(list_path);
    if (list.split != split) {
      throw InputError(list_path.string(),
                       fmt::format("is of the split {}, expected {}", list.split, split));
    }
    std::map<std::pair<std::string, int>, int> conversations;
    for (const ViewPair& pair : spread(std::move(list.pairs), limit)) {
      const auto known = conversations.try_emplace({pair.scene, pair.clip},
                                                   static_cast<int>(conversations.size()));
      pairs_.push_back(
          {pair, &clip_of(pair, dataset_.clips(), list_path.string()), known.first->second});
    }
    if (pairs_.empty()) throw InputError(list_path.string(), "holds no pairs");
  }

  [[nodiscard]] std::size_t size() const override { return pairs_.size(); }
  [[nodiscard]] std::string name(std::size_t pair) const override {
    const ViewPair& view = pairs_.at(pair).pair;
    const std::string way = target_ == PairTarget::viewpoint
                                ? fmt::format("{} -> {}", view.choice.source, view.choice.target)
                                : fmt::format("from {}", view.choice.source);
    return fmt::format("{}, clip {}: {}, speaker {}, at {:.2f} s", view.scene, view.clip, way,
                       view.choice.speaker,
                       static_cast<double>(view.choice.window_start) / 16000.0);
  }
  [[nodiscard]] std::string scene(std::size_t pair) const override {
    return pairs_.at(pair).pair.scene;
  }
  [[nodiscard]] int cluster(std::size_t pair) const override { return pairs_.at(pair).cluster; }
  [[nodiscard]] PairSample sample(std::size_t pair) const override {
    return sampler_.sample(*pairs_.at(pair).clip, pairs_[pair].pair.choice);
  }
  [[nodiscard]] std::optional<PairTruth> truth(std::size_t pair) const override {
    return sampler_.truth(*pairs_.at(pair).clip, pairs_[pair].pair.choice);
  }

 private:
  struct Entry {
    ViewPair pair;
    const SoundSpacesClip* clip;
    int cluster;
  };
  SoundSpacesDataset dataset_;
  PairSampler sampler_;
  PairTarget target_;
  std::vector<Entry> pairs_;
};

}  // namespace

std::unique_ptr<EvaluationSet> soundspaces_evaluation_set(
    const fs::path& folder, const std::string& split, const std::optional<fs::path>& pair_list,
    std::optional<std::size_t> limit, std::size_t cache_bytes, PairTarget target) {
  const fs::path list = pair_list.value_or(folder / ("pairs-" + split + ".json"));
  return std::make_unique<SoundSpacesEvaluationSet>(folder, split, list, limit, cache_bytes,
                                                    target);
}

}  // namespace earpoint
