#include <earpoint/core/error.h>
#include <earpoint/train/training_batch.h>

namespace earpoint {
namespace {

void append(std::vector<float>& all, const std::vector<float>& one, std::size_t size) {
  EARPOINT_CHECK(one.size() == size);
  all.insert(all.end(), one.begin(), one.end());
}

}  // namespace

TrainingBatch join(std::span<const TrainingExample> examples) {
  EARPOINT_CHECK(!examples.empty());
  const TrainingExample& first = examples.front();
  TrainingBatch batch;
  for (const TrainingExample& example : examples) {
    append(batch.source, example.source, first.source.size());
    append(batch.target, example.target, first.target.size());
    append(batch.pictures, example.picture, first.picture.size());
    EARPOINT_CHECK(example.inputs.size() == first.inputs.size());
    for (const auto& [name, values] : example.inputs) {
      append(batch.inputs[name], values, first.inputs.at(name).size());
    }
    ++batch.clips;
  }
  return batch;
}

}  // namespace earpoint
