#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/soundspaces.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/evaluation_set.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// `limit` pairs, spread evenly over the list, as neighbours in it are of the same conversation.
std::vector<ViewPair> spread(std::vector<ViewPair> pairs, std::optional<std::size_t> limit) {
  if (!limit || *limit >= pairs.size()) return pairs;
  std::vector<ViewPair> chosen;
  for (std::size_t i = 0; i < *limit; ++i) chosen.push_back(pairs[i * pairs.size() / *limit]);
  return chosen;
}

/// A list of pairs and its origin.
struct Origin {
  PairList list;
  std::string where;
};

Origin pairs_of(const SoundSpacesDataset& dataset, const fs::path& folder,
                const PairChoice& choice) {
  if (choice.draw == PairDraw::released) {
    return {draw_pair_list(dataset, *choice.draw, kPairDrawSeed),
            "drawn as the released test does"};
  }
  const auto found = choice.list ? choice.list : find_pair_list(folder, dataset.split());
  if (choice.draw || !found) {
    return {draw_pair_list(dataset, PairDraw::every_target, kPairDrawSeed),
            fmt::format("drawn, every viewpoint the target once, seed {}", kPairDrawSeed)};
  }
  Origin origin{read_pair_list(*found), found->string()};
  if (origin.list.split != dataset.split()) {
    throw InputError(origin.where, fmt::format("is of the split {}, expected {}", origin.list.split,
                                               dataset.split()));
  }
  return origin;
}

class SoundSpacesEvaluationSet : public EvaluationSet {
 public:
  SoundSpacesEvaluationSet(const fs::path& folder, const std::string& split,
                           const PairChoice& choice, std::optional<std::size_t> limit,
                           std::size_t cache_bytes, PairTarget target, std::ptrdiff_t context)
      : dataset_(soundspaces_options(folder, split)),
        sampler_(dataset_, cache_bytes, ResponseDelays::dropped, target),
        target_(target),
        context_(context) {
    Origin origin = pairs_of(dataset_, folder, choice);
    where_ = origin.where;
    std::map<std::pair<std::string, int>, int> conversations;
    for (const ViewPair& pair : spread(std::move(origin.list.pairs), limit)) {
      const auto known = conversations.try_emplace({pair.scene, pair.clip},
                                                   static_cast<int>(conversations.size()));
      pairs_.push_back({pair, &clip_of(pair, dataset_.clips(), where_), known.first->second});
    }
    if (pairs_.empty()) throw InputError(where_, "holds no pairs");
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
  /// The reader is the first part of a recording's name.
  [[nodiscard]] std::optional<std::string> voice(std::size_t pair) const override {
    const Entry& entry = pairs_.at(pair);
    const std::string& speech = *entry.clip->speakers[entry.pair.choice.speaker].speech;
    return speech.substr(0, speech.find('-'));
  }
  [[nodiscard]] std::string pairs() const override { return where_; }
  [[nodiscard]] PairSample sample(std::size_t pair) const override {
    return sampler_.sample(*pairs_.at(pair).clip, pairs_[pair].pair.choice, kPairSamples, context_);
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
  std::ptrdiff_t context_;
  std::string where_;
  std::vector<Entry> pairs_;
};

}  // namespace

std::unique_ptr<EvaluationSet> soundspaces_evaluation_set(
    const fs::path& folder, const std::string& split, const PairChoice& pairs,
    std::optional<std::size_t> limit, std::size_t cache_bytes, PairTarget target,
    std::ptrdiff_t context) {
  return std::make_unique<SoundSpacesEvaluationSet>(folder, split, pairs, limit, cache_bytes,
                                                    target, context);
}

}  // namespace earpoint
