#include "description_section.h"
#include "task_kinds.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/people/description.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/people_example.h>
#include <earpoint/train/people_learner.h>

namespace earpoint {
namespace {

using D = PeopleDescription;

struct PictureOptions {
  int width = 256;
  int height = 160;
  int validation_pictures = 512;  ///< evenly spread; 0 takes all
};

PictureOptions picture_options(std::string_view text, std::string_view where) {
  const nlohmann::json json = parse_strict_json(text, where, 1);
  JsonObjectReader reader(json, where);
  PictureOptions options;
  const auto size = [&](const char* key, int& pixels) {
    if (reader.has(key)) pixels = reader.integer(key);
    if (pixels < D::kCoarsest || pixels > 2048 || pixels % D::kCoarsest != 0) {
      throw InputError(where, fmt::format("'{}': expected a multiple of {} up to 2048, found {}",
                                          key, D::kCoarsest, pixels));
    }
  };
  size("view_width_px", options.width);
  size("view_height_px", options.height);
  if (reader.has("validation_pictures")) {
    options.validation_pictures = reader.integer("validation_pictures");
  }
  reader.expect_nothing_else();
  if (options.validation_pictures < 0) {
    throw InputError(where, "'validation_pictures': expected 0 or more");
  }
  return options;
}

/// Pictures of `train` with random changes, and of `val` unchanged.
class PictureExamples : public ExampleLoader {
 public:
  PictureExamples(const TaskOptions& options, const PictureOptions& pictures, std::uint64_t seed)
      : options_(pictures),
        seed_(seed),
        on_bad_(options.on_bad),
        train_(read_people_pictures(options.data, "train")),
        held_out_(read_people_pictures(options.data, "val")),
        chosen_(evenly_spread(held_out_.size(),
                              static_cast<std::size_t>(pictures.validation_pictures))) {}

  [[nodiscard]] TrainingExample training(std::uint64_t number) const override {
    RandomStream random(seed_, {number});
    for (std::uint64_t attempt = 1;; ++attempt) {
      const PeoplePicture& labels = train_[random.index(train_.size())];
      try {
        return people_example(varied_people_view(read_image(labels.file), labels, options_.width,
                                                 options_.height, random));
      } catch (const InputError& error) {
        if (!on_bad_ || attempt == kMostBadExamples) throw;
        on_bad_(error.what());
      }
    }
  }

  [[nodiscard]] std::size_t validations() const override { return chosen_.size(); }

  [[nodiscard]] std::optional<TrainingExample> validation(std::size_t index) const override {
    const PeoplePicture& labels = held_out_[chosen_[index]];
    try {
      return people_example(
          plain_people_view(read_image(labels.file), labels, options_.width, options_.height));
    } catch (const InputError& error) {
      if (!on_bad_) throw;
      on_bad_(error.what());
      return std::nullopt;
    }
  }

 private:
  PictureOptions options_;
  std::uint64_t seed_;
  std::function<void(const std::string&)> on_bad_;
  std::vector<PeoplePicture> train_;
  std::vector<PeoplePicture> held_out_;
  std::vector<std::size_t> chosen_;
};

}  // namespace

TrainingTask people_task(const TrainConfig& config, std::string_view where,
                         const TaskOptions& options) {
  const std::string network = fmt::format("{}: 'network'", where);
  const PeopleDescription description = people_description_from_json(
      description_with(config.network, to_json(PeopleDescription{}), network), network);
  const PictureOptions pictures = picture_options(config.data, fmt::format("{}: 'data'", where));
  TrainingTask task;
  task.examples = std::make_unique<PictureExamples>(options, pictures, config.training.seed);
  auto learner = std::make_unique<PeopleLearner>(
      options.checkpoint == nullptr
          ? PeopleLearner(initial_people_weights(description, config.training.seed), pictures.width,
                          pictures.height, options.device)
          : PeopleLearner::from_checkpoint(*options.checkpoint, "the checkpoint", pictures.width,
                                           pictures.height, options.device));
  if (to_json(learner->description()) != to_json(description)) {
    throw InputError(where, "describes a different network from the checkpoint");
  }
  task.learner = std::move(learner);
  return task;
}

}  // namespace earpoint
