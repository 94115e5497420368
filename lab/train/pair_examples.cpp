#include "faint_speech.h"
#include "spoil_view.h"
#include "told_boxes.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/ambient.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/sample.h>
#include <earpoint/error.h>
#include <earpoint/train/example_loader.h>

namespace earpoint {
namespace {

// The limit of the released loader for the delay: 4 m of distance.
constexpr double kLargestShift = 200.0;
/// Draws for one example within the limits: if only 2 % are within, one in 10^8 examples finds
/// none.
constexpr std::uint64_t kMostDraws = 1000;
constexpr double kFaintNoise_db = -40.0;
constexpr double kMostSecondGain_db = 6.0;
// The seed of validation pairs that are drawn because there is no list.
constexpr std::uint64_t kValidationDraw = 1;

/// Keys of random streams: the draws of an example, and of its noise.
enum Purpose : std::uint64_t { kDraw = 1, kNoise = 2, kValidationNoise = 3 };

bool is_silent(std::span<const float> sound) {
  return std::ranges::all_of(sound, [](float sample) { return sample == 0.0F; });
}

/// Moves the target's sound earlier by its delay to the source, found by GCC-PHAT.
void align_target(PairSample& sample) {
  const std::vector<float> source = mean_of_channels(sample.source);
  const std::vector<float> target = mean_of_channels(sample.target);
  if (is_silent(source) || is_silent(target)) return;
  const auto later = static_cast<int>(gcc_phat_delay_samples(target, source, kLargestShift));
  sample.target = shifted(sample.target, -later);
}

std::vector<int> speaking(const SoundSpacesClip& clip) {
  std::vector<int> found;
  for (std::size_t i = 0; i < clip.speakers.size(); ++i) {
    if (clip.speakers[i].speech) found.push_back(static_cast<int>(i));
  }
  if (found.empty()) {
    throw InputError(fmt::format("{}, clip {}", clip.scene, clip.index), "nobody has speech");
  }
  return found;
}

/// The training split of one folder.
struct TrainingClips {
  TrainingClips(const std::filesystem::path& folder, const PairOptions& options,
                std::size_t cache_bytes)
      : data(soundspaces_options(folder, "train")),
        sampler(data, cache_bytes,
                options.alignment == Alignment::responses ? ResponseDelays::dropped
                                                          : ResponseDelays::relative,
                options.target) {}

  SoundSpacesDataset data;
  PairSampler sampler;
};

}  // namespace

std::vector<std::size_t> evenly_spread(std::size_t size, std::size_t count) {
  if (count == 0 || count > size) count = size;
  std::vector<std::size_t> chosen(count);
  for (std::size_t i = 0; i < count; ++i) chosen[i] = i * size / count;
  return chosen;
}

struct PairExamples::State {
  State(PairOptions pair_options, PairEncoder encoder)
      : options(std::move(pair_options)),
        encode(std::move(encoder)),
        boxes(options.boxes),
        val(soundspaces_options(options.data, "val")),
        // Validation does not depend on the options of training, so that runs can be compared.
        val_sampler(val, options.cache_bytes / 4, ResponseDelays::dropped, options.target) {
    const std::size_t cache_bytes = options.cache_bytes / (1 + options.more_data.size());
    train.push_back(std::make_unique<TrainingClips>(options.data, options, cache_bytes));
    for (const auto& folder : options.more_data) {
      train.push_back(std::make_unique<TrainingClips>(folder, options, cache_bytes));
    }
    for (const auto& clips : train) train_clips += clips->data.clips().size();
    const auto list = find_pair_list(options.data, "val");
    const PairList pairs =
        list ? read_pair_list(*list) : draw_pair_list(val, PairDraw::every_target, kValidationDraw);
    const std::string where = list ? list->string() : "the drawn pairs";
    for (const std::size_t index : evenly_spread(pairs.pairs.size(), options.validation_pairs)) {
      const ViewPair& pair = pairs.pairs[index];
      validation.emplace_back(&clip_of(pair, val.clips(), where), pair.choice);
    }
    if (validation.empty()) throw InputError(where, "holds no pair");
  }

  /// The beginning of a window of the speaker's speech.
  [[nodiscard]] std::ptrdiff_t draw_start(const PairSampler& sampler,
                                          const SoundSpacesSpeaker& speaker,
                                          RandomStream& random) const {
    const std::ptrdiff_t spare = sampler.speech_samples(speaker) - options.samples;
    if (spare <= 0) return 0;
    return static_cast<std::ptrdiff_t>(random.index(static_cast<std::uint64_t>(spare) + 1));
  }

  [[nodiscard]] SoundSpacesChoice draw_choice(const PairSampler& sampler,
                                              const SoundSpacesClip& clip,
                                              RandomStream& random) const {
    SoundSpacesChoice choice;
    const std::size_t viewpoints = clip.viewpoints.size();
    choice.source = static_cast<int>(random.index(viewpoints));
    choice.target = static_cast<int>(random.index(viewpoints - 1));
    if (choice.target >= choice.source) ++choice.target;
    const std::vector<int> speakers = speaking(clip);
    choice.speaker = speakers[random.index(speakers.size())];
    choice.window_start = draw_start(sampler, clip.speakers[choice.speaker], random);
    return choice;
  }

  void add_room(PairSample& sample, std::uint64_t noise_seed) const {
    if (!options.ambient_db) return;
    if (options.target == PairTarget::viewpoint) {
      add_ambient(sample, *options.ambient_db, noise_seed);
    } else {
      RandomStream random(noise_seed);
      add_room_noise(sample.source, *options.ambient_db, random);
    }
    if (!options.separate) return;
    separate_source(sample, options.separation);
    if (options.target == PairTarget::viewpoint) {
      sample.target = primary_sound(sample.target, options.separation);
    }
  }

  /// A clip of any folder's training split, and the folder.
  struct Drawn {
    const TrainingClips& from;
    const SoundSpacesClip& clip;
  };
  [[nodiscard]] Drawn draw_clip(RandomStream& random) const {
    std::size_t index = random.index(train_clips);
    std::size_t folder = 0;
    while (index >= train[folder]->data.clips().size()) {
      index -= train[folder++]->data.clips().size();
    }
    return {*train[folder], train[folder]->data.clips()[index]};
  }

  /// The same positions and responses with any speech of the folder's split.
  [[nodiscard]] PairSample other_words(const Drawn& drawn, SoundSpacesChoice choice,
                                       RandomStream& random) const {
    const auto& [from, clip] = drawn;
    const SoundSpacesClip& other = from.data.clips()[random.index(from.data.clips().size())];
    const std::vector<int> speakers = speaking(other);
    SoundSpacesClip retold = clip;
    SoundSpacesSpeaker& speaker = retold.speakers[choice.speaker];
    speaker.speech = other.speakers[speakers[random.index(speakers.size())]].speech;
    choice.window_start = draw_start(from.sampler, speaker, random);
    return from.sampler.sample(retold, choice, options.samples);
  }

  /// Lets another of the clip's people speak at the same time, whatever anybody of the split says.
  void add_second_voice(PairSample& sample, const Drawn& drawn, SoundSpacesChoice choice,
                        RandomStream& random) const {
    const auto people = static_cast<int>(drawn.clip.speakers.size());
    if (people < 2) return;
    const auto others = static_cast<std::uint64_t>(people - 1);
    choice.speaker = (choice.speaker + 1 + static_cast<int>(random.index(others))) % people;
    const PairSample other = other_words(drawn, choice, random);
    const double gain_db = random.uniform(-kMostSecondGain_db, kMostSecondGain_db);
    const auto gain = static_cast<float>(std::pow(10.0, gain_db / 20.0));
    const auto add = [gain](std::span<float> sound, std::span<const float> voice) {
      for (std::size_t i = 0; i < sound.size(); ++i) sound[i] += gain * voice[i];
    };
    add(sample.source.planar(), other.source.planar());
    add(sample.target.planar(), other.target.planar());
  }

  /// Whether a pair is within the limits for training.
  [[nodiscard]] bool is_wanted(const PairSample& sample) const {
    if (options.farthest_move_m &&
        norm(sample.source_from_target.position_m) > *options.farthest_move_m) {
      return false;
    }
    return !options.most_gain_db ||
           energy(sample.target.planar()) <=
               energy(sample.source.planar()) * std::pow(10.0, *options.most_gain_db / 10.0);
  }

  /// @return nothing for a pair outside the limits
  [[nodiscard]] std::optional<PairSample> training_sample(std::uint64_t number,
                                                          std::uint64_t attempt) const {
    RandomStream random(options.seed, {kDraw, number, attempt});
    const Drawn drawn = draw_clip(random);
    const auto& [from, clip] = drawn;
    const SoundSpacesChoice choice = draw_choice(from.sampler, clip, random);
    PairSample sample = options.any_speech ? other_words(drawn, choice, random)
                                           : from.sampler.sample(clip, choice, options.samples);
    if (!is_wanted(sample)) return std::nullopt;
    // Drawn only with the option, so that other draws stay as they were without it.
    if (options.second_voices > 0.0 && random.uniform() < options.second_voices) {
      add_second_voice(sample, drawn, choice, random);
    }
    if (options.faint_speech > 0.0 && random.uniform() < options.faint_speech) {
      make_faint(sample, options.target, options.ambient_db.value_or(kFaintNoise_db), random);
    }
    add_room(sample, RandomStream(options.seed, {kNoise, number}).next());
    boxes.tell(sample);
    if (options.alignment == Alignment::gcc_phat) align_target(sample);
    // Always drawn, so that other draws do not depend on the option.
    const bool is_mirrored = random.index(2) == 1;
    if (options.mirror && is_mirrored) sample = mirrored(sample);
    spoil_view(sample, from, random);
    return sample;
  }

  /// Degrades the view as a user's camera may.
  void spoil_view(PairSample& sample, const TrainingClips& from, RandomStream& random) const {
    const bool is_spoilt = random.uniform() < options.spoilt_pictures;
    const bool is_hidden = random.uniform() < options.hidden_boxes;
    // Drawn only with the option, so that other draws stay as they were without it.
    if (options.wide_pictures > 0.0 && random.uniform() < options.wide_pictures) {
      widen_picture(sample);
    }
    if (is_hidden) sample.speaker_box.reset();
    if (!is_spoilt) return;
    const SoundSpacesClip& other = from.data.clips()[random.index(from.data.clips().size())];
    const auto viewpoint = static_cast<int>(random.index(other.viewpoints.size()));
    sample.picture =
        spoilt_picture(*sample.picture, from.sampler.picture(other, viewpoint), random);
  }

  PairOptions options;
  PairEncoder encode;
  ToldBoxes boxes;
  std::vector<std::unique_ptr<TrainingClips>> train;
  std::size_t train_clips = 0;
  SoundSpacesDataset val;
  PairSampler val_sampler;
  std::vector<std::pair<const SoundSpacesClip*, SoundSpacesChoice>> validation;
};

PairExamples::PairExamples(PairOptions options, PairEncoder encode)
    : state_(std::make_unique<State>(std::move(options), std::move(encode))) {}
PairExamples::~PairExamples() = default;

PairSample PairExamples::training_sample(std::uint64_t number) const {
  std::uint64_t bad = 0;
  for (std::uint64_t attempt = 0; attempt < kMostDraws; ++attempt) {
    try {
      if (auto sample = state_->training_sample(number, attempt)) return std::move(*sample);
    } catch (const InputError& error) {
      if (!state_->options.on_bad || bad++ == kMostBadExamples) throw;
      state_->options.on_bad(error.what());
    }
  }
  throw InputError(state_->options.data.string(),
                   "too few pairs are within 'farthest_move_m' and 'most_gain_db'", "raise them");
}

TrainingExample PairExamples::training(std::uint64_t number) const {
  return state_->encode(training_sample(number));
}

std::size_t PairExamples::validations() const { return state_->validation.size(); }

std::optional<TrainingExample> PairExamples::validation(std::size_t index) const {
  const auto& [clip, choice] = state_->validation.at(index);
  try {
    PairSample sample = state_->val_sampler.sample(*clip, choice);
    state_->add_room(sample, RandomStream(1, {kValidationNoise, index}).next());
    state_->boxes.tell(sample);
    return state_->encode(sample);
  } catch (const InputError& error) {
    if (!state_->options.on_bad) throw;
    state_->options.on_bad(error.what());
    return std::nullopt;
  }
}

}  // namespace earpoint
