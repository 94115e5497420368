#include "told_boxes.h"

#include <utility>

#include <fmt/format.h>

#include <earpoint/core/random.h>
#include <earpoint/dataset/numpy_random.h>
#include <earpoint/error.h>
#include <earpoint/train/example_loader.h>

namespace earpoint {
namespace {

// The seed of the released draw of pairs.
constexpr std::uint32_t kValidationSeed = 0;

/// Refuses options that recordings cannot satisfy.
PairOptions checked(PairOptions options) {
  if (!options.more_data.empty()) {
    throw InputError(options.more_data.front().string(),
                     "recordings of Replay-NVAS are read from one folder", "give one folder");
  }
  const auto refuse = [](const char* key, const char* expected) {
    throw InputError(fmt::format("'data': '{}'", key),
                     fmt::format("expected {} for recordings of Replay-NVAS", expected));
  };
  const bool is_moved = options.target == PairTarget::viewpoint;
  if (is_moved && options.alignment == Alignment::responses) {
    refuse("align", "\"gcc_phat\" or \"none\"");
  }
  if (options.ambient_db) refuse("ambient_db", "null");
  if (options.any_speech) refuse("any_speech", "false");
  if (options.spoilt_pictures > 0.0) refuse("spoilt_pictures", "0");
  if (options.faint_speech > 0.0) refuse("faint_speech", "0");
  if (options.second_voices > 0.0) refuse("second_voices", "0");
  if (options.wide_pictures > 0.0) refuse("wide_pictures", "0");
  if (options.hidden_boxes > 0.0) refuse("hidden_boxes", "0");
  if (options.farthest_move_m) refuse("farthest_move_m", "null");
  if (options.most_gain_db) refuse("most_gain_db", "null");
  if (options.samples != kPairSamples) refuse("window_samples", "16000");
  return options;
}

}  // namespace

ReplayExamples::ReplayExamples(PairOptions options, PairEncoder encode)
    : options_(checked(std::move(options))),
      encode_(std::move(encode)),
      boxes_(std::make_unique<ToldBoxes>(options_.boxes)),
      train_(replay_options(options_.data, "train")),
      val_(replay_options(options_.data, "val")),
      train_sampler_(train_, options_.cache_bytes),
      val_sampler_(val_, options_.cache_bytes / 4) {
  NumpyRandom random(kValidationSeed);
  std::vector<std::pair<const ReplayClip*, ReplayChoice>> all;
  for (const ReplayClip& clip : val_.clips()) all.emplace_back(&clip, val_.draw(clip, random));
  for (const std::size_t index : evenly_spread(all.size(), options_.validation_pairs)) {
    validation_.push_back(all[index]);
  }
}

ReplayExamples::~ReplayExamples() = default;

PairSample ReplayExamples::sample(const ReplaySampler& sampler, const ReplayClip& clip,
                                  const ReplayChoice& choice) const {
  PairSample sample;
  if (options_.target == PairTarget::near_microphone) {
    sample = sampler.enhancement_sample(clip, choice.source);
  } else {
    sample = sampler.sample(clip, choice, options_.alignment == Alignment::gcc_phat);
    if (options_.near_voice) sample.dry = sampler.near_voice(clip, sample.source);
  }
  boxes_->tell(sample);
  return sample;
}

PairSample ReplayExamples::training_sample(std::uint64_t number, std::uint64_t attempt) const {
  RandomStream random(options_.seed, {number, attempt});
  const ReplayClip& clip = train_.clips()[random.index(train_.clips().size())];
  ReplayChoice choice;
  choice.source = static_cast<int>(random.index(clip.images.size()));
  choice.target = static_cast<int>(random.index(clip.images.size() - 1));
  if (choice.target >= choice.source) ++choice.target;
  const bool is_mirrored = random.index(2) == 1;
  PairSample drawn = sample(train_sampler_, clip, choice);
  return options_.mirror && is_mirrored ? mirrored(drawn) : drawn;
}

TrainingExample ReplayExamples::training(std::uint64_t number) const {
  for (std::uint64_t attempt = 0;; ++attempt) {
    try {
      return encode_(training_sample(number, attempt));
    } catch (const InputError& error) {
      if (!options_.on_bad || attempt == kMostBadExamples) throw;
      options_.on_bad(error.what());
    }
  }
}

std::optional<TrainingExample> ReplayExamples::validation(std::size_t index) const {
  const auto& [clip, choice] = validation_.at(index);
  try {
    return encode_(sample(val_sampler_, *clip, choice));
  } catch (const InputError& error) {
    if (!options_.on_bad) throw;
    options_.on_bad(error.what());
    return std::nullopt;
  }
}

std::unique_ptr<ExampleLoader> pair_examples(PairOptions options, PairEncoder encode) {
  if (dataset_layout(options.data, options.layout) == DatasetLayout::replay) {
    return std::make_unique<ReplayExamples>(std::move(options), std::move(encode));
  }
  return std::make_unique<PairExamples>(std::move(options), std::move(encode));
}

}  // namespace earpoint
