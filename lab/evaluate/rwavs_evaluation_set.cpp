#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/rwavs.h>
#include <earpoint/evaluate/evaluation_set.h>

namespace earpoint {
namespace {

class RwavsEvaluationSet : public EvaluationSet {
 public:
  RwavsEvaluationSet(const std::filesystem::path& folder, const std::string& split,
                     std::optional<std::size_t> limit)
      : dataset_(rwavs_options(folder, split)) {
    const std::vector<RwavsMoment>& all = dataset_.moments();
    const std::size_t count = std::min(limit.value_or(all.size()), all.size());
    std::map<std::string, int> scenes;
    for (std::size_t i = 0; i < count; ++i) {
      const RwavsMoment& moment = all[i * all.size() / count];
      const auto scene = scenes.try_emplace(moment.scene, static_cast<int>(scenes.size()));
      moments_.push_back({&moment, scene.first->second});
    }
  }

  [[nodiscard]] std::size_t size() const override { return moments_.size(); }
  [[nodiscard]] std::string name(std::size_t pair) const override {
    const RwavsMoment& moment = *moments_.at(pair).moment;
    return fmt::format("scene {}, {} s", moment.scene, moment.time_s);
  }
  [[nodiscard]] std::string scene(std::size_t pair) const override {
    return moments_.at(pair).moment->scene;
  }
  [[nodiscard]] int cluster(std::size_t pair) const override { return moments_.at(pair).scene; }
  [[nodiscard]] std::string pairs() const override { return "every pose of the split"; }
  [[nodiscard]] PairSample sample(std::size_t pair) const override {
    return dataset_.sample(*moments_.at(pair).moment);
  }
  [[nodiscard]] std::optional<PairTruth> truth(std::size_t /*pair*/) const override {
    return std::nullopt;
  }

 private:
  struct Entry {
    const RwavsMoment* moment = nullptr;
    int scene = 0;
  };
  RwavsDataset dataset_;
  std::vector<Entry> moments_;
};

}  // namespace

std::unique_ptr<EvaluationSet> rwavs_evaluation_set(const std::filesystem::path& folder,
                                                    const std::string& split,
                                                    std::optional<std::size_t> limit) {
  return std::make_unique<RwavsEvaluationSet>(folder, split, limit);
}

}  // namespace earpoint
