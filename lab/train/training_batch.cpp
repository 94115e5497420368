#include <earpoint/train/training_batch.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

void append(std::vector<float>& all, const std::vector<float>& one, std::size_t size) {
  EARPOINT_CHECK(one.size() == size);
  all.insert(all.end(), one.begin(), one.end());
}

std::vector<float> slice(const std::vector<float>& all, std::int64_t clips, std::int64_t first,
                         std::int64_t count) {
  const auto size = std::ssize(all) / clips;
  return {all.begin() + first * size, all.begin() + (first + count) * size};
}

}  // namespace

TrainingBatch clips_of(const TrainingBatch& batch, std::int64_t first, std::int64_t count) {
  EARPOINT_CHECK(0 <= first && 0 < count && first + count <= batch.clips);
  TrainingBatch part;
  part.clips = count;
  part.source = slice(batch.source, batch.clips, first, count);
  part.target = slice(batch.target, batch.clips, first, count);
  part.pictures = slice(batch.pictures, batch.clips, first, count);
  for (const auto& [name, values] : batch.inputs) {
    part.inputs[name] = slice(values, batch.clips, first, count);
  }
  return part;
}

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
