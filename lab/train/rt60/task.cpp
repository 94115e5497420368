#include "description_section.h"
#include "task_kinds.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/strict_json.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/reverberant_speech.h>
#include <earpoint/error.h>
#include <earpoint/rt60/description.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/rt60_learner.h>

namespace earpoint {
namespace {

struct SpeechOptions {
  int responses = 1500;          ///< that are kept of each split
  int validation_seconds = 256;  ///< spread evenly over the responses
};

SpeechOptions speech_options(std::string_view text, std::string_view where) {
  const nlohmann::json json = parse_strict_json(text, where, 1);
  JsonObjectReader reader(json, where);
  SpeechOptions options;
  if (reader.has("responses")) options.responses = reader.integer("responses");
  if (reader.has("validation_seconds")) {
    options.validation_seconds = reader.integer("validation_seconds");
  }
  reader.expect_nothing_else();
  if (options.responses < 1 || options.validation_seconds < 1) {
    throw InputError(where, "'responses' and 'validation_seconds': expected 1 or more");
  }
  return options;
}

/// Seconds of speech in known rooms: with random changes for `train`, unchanged for `val`.
class SpeechExamples : public ExampleLoader {
 public:
  SpeechExamples(const std::filesystem::path& data, const SpeechOptions& options,
                 std::uint64_t seed)
      : seed_(seed),
        train_(SoundSpacesDataset(soundspaces_options(data, "train")),
               static_cast<std::size_t>(options.responses)),
        held_out_(SoundSpacesDataset(soundspaces_options(data, "val")),
                  static_cast<std::size_t>(options.responses)),
        validations_(std::min(held_out_.responses(),
                              static_cast<std::size_t>(options.validation_seconds))) {}

  [[nodiscard]] TrainingExample training(std::uint64_t number) const override {
    RandomStream random(seed_, {number});
    ReverberantSecond second = train_.draw(random);
    return rt60_example(std::move(second.sound), second.t60_s);
  }

  [[nodiscard]] std::size_t validations() const override { return validations_; }

  [[nodiscard]] std::optional<TrainingExample> validation(std::size_t index) const override {
    const std::size_t response = index * held_out_.responses() / validations_;
    RandomStream random(0, {response});
    ReverberantSecond second = held_out_.measured(response, random);
    return rt60_example(std::move(second.sound), second.t60_s);
  }

 private:
  std::uint64_t seed_;
  ReverberantSpeech train_;
  ReverberantSpeech held_out_;
  std::size_t validations_;
};

}  // namespace

TrainingTask rt60_task(const TrainConfig& config, std::string_view where,
                       const TaskOptions& options) {
  const std::string network = fmt::format("{}: 'network'", where);
  const Rt60Description description = rt60_description_from_json(
      description_with(config.network, to_json(Rt60Description{}), network), network);
  TrainingTask task;
  task.examples = std::make_unique<SpeechExamples>(
      options.data, speech_options(config.data, fmt::format("{}: 'data'", where)),
      config.training.seed);
  auto learner = std::make_unique<Rt60Learner>(
      options.checkpoint == nullptr
          ? Rt60Learner(initial_rt60_weights(description, config.training.seed), options.device)
          : Rt60Learner::from_checkpoint(*options.checkpoint, "the checkpoint", options.device));
  if (to_json(learner->description()) != to_json(description)) {
    throw InputError(where, "describes a different network from the checkpoint");
  }
  task.learner = std::move(learner);
  return task;
}

}  // namespace earpoint
