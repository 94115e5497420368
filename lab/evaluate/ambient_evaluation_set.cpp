#include <utility>

#include <earpoint/core/random.h>
#include <earpoint/dataset/ambient.h>
#include <earpoint/evaluate/evaluation_set.h>

namespace earpoint {
namespace {

constexpr std::uint64_t kSeed = 20230618;

class AmbientEvaluationSet : public EvaluationSet {
 public:
  AmbientEvaluationSet(std::unique_ptr<EvaluationSet> set, double level_db,
                       AmbientSeparation separation)
      : set_(std::move(set)), level_db_(level_db), separation_(separation) {}

  [[nodiscard]] std::size_t size() const override { return set_->size(); }
  [[nodiscard]] std::string name(std::size_t pair) const override { return set_->name(pair); }
  [[nodiscard]] std::string scene(std::size_t pair) const override { return set_->scene(pair); }
  [[nodiscard]] int cluster(std::size_t pair) const override { return set_->cluster(pair); }
  [[nodiscard]] std::optional<std::string> voice(std::size_t pair) const override {
    return set_->voice(pair);
  }
  [[nodiscard]] std::string pairs() const override { return set_->pairs(); }
  [[nodiscard]] PairSample sample(std::size_t pair) const override {
    return noisy(set_->sample(pair), pair);
  }
  [[nodiscard]] bool knows_speaker() const override { return set_->knows_speaker(); }
  [[nodiscard]] std::optional<PairTruth> truth(std::size_t pair) const override {
    return set_->truth(pair);
  }
  [[nodiscard]] std::optional<PairSample> released_sample(std::size_t pair) const override {
    std::optional<PairSample> sample = set_->released_sample(pair);
    if (sample) sample = noisy(std::move(*sample), pair);
    return sample;
  }

 private:
  [[nodiscard]] PairSample noisy(PairSample sample, std::size_t pair) const {
    RandomStream random(kSeed, {pair});
    sample.clean = sample.source;
    add_room_noise(sample.source, level_db_, random, sample.context);
    separate_source(sample, separation_);
    return sample;
  }

  std::unique_ptr<EvaluationSet> set_;
  double level_db_;
  AmbientSeparation separation_;
};

}  // namespace

std::unique_ptr<EvaluationSet> with_ambient(std::unique_ptr<EvaluationSet> set, double level_db,
                                            AmbientSeparation separation) {
  return std::make_unique<AmbientEvaluationSet>(std::move(set), level_db, separation);
}

}  // namespace earpoint
