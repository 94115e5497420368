#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/dataset/speaker_boxes.h>
#include <earpoint/train/training_batch.h>

namespace earpoint {

class ToldBoxes;

/// Where a Trainer's examples come from. Any thread may call it.
class ExampleLoader {
 public:
  virtual ~ExampleLoader() = default;

  /// Example number `number` of the run: the same number gives the same example.
  [[nodiscard]] virtual TrainingExample training(std::uint64_t number) const = 0;

  /// How many examples there are to validate on.
  [[nodiscard]] virtual std::size_t validations() const = 0;

  /// @return nothing for an example that is bad and may be skipped
  [[nodiscard]] virtual std::optional<TrainingExample> validation(std::size_t index) const = 0;
};

/// What becomes of the time between source and target. A network that makes sound of sound, sample
/// by sample, learns badly what it would have to shift.
enum class Alignment {
  responses,  ///< every response's delay is dropped, as in the published data set
  gcc_phat,   ///< delays are kept, and the target is shifted by what GCC-PHAT finds
  none,       ///< delays are kept
};

/// How pairs of viewpoints become examples.
struct PairOptions {
  std::filesystem::path data;  ///< a folder that dataset_layout() knows
  /// Further ones whose clips of `train` are drawn as often; in the SoundSpaces layout.
  std::vector<std::filesystem::path> more_data;
  std::optional<DatasetLayout> layout;  ///< of it; nothing: whichever there is
  std::uint64_t seed = 1;               ///< of the draws in training
  std::ptrdiff_t samples = 16000;       ///< of a training window; validation takes a second
  bool any_speech = false;              ///< a speaker says any speech of the split
  bool mirror = true;            ///< half of the training examples are mirrored, left to right
  double spoilt_pictures = 0.0;  ///< share of training examples whose picture tells nothing
  double wide_pictures = 0.0;    ///< share of training examples whose picture is cut to 16:9
  double hidden_boxes = 0.0;     ///< share of training examples without the speaker's box
  /// Which box of the speaker examples have, in validation too. The people detector is the shipped
  /// one.
  SpeakerBoxes boxes = SpeakerBoxes::truth;
  /// Training pairs whose target is farther from the source are not drawn.
  std::optional<double> farthest_move_m;
  /// Training pairs whose target is by more louder than the source are not drawn: from behind a
  /// closed door to the speaker, say. Level of the window over both ears.
  std::optional<double> most_gain_db;
  PairTarget target = PairTarget::viewpoint;   ///< in validation too
  Alignment alignment = Alignment::responses;  ///< in training; validation pairs are aligned
  /// Level of room noise in both sounds, dB re full scale; near microphones hear none.
  std::optional<double> ambient_db;
  /// Share of training examples whose speech is faint among other sounds of ambient_db, of -40 dB
  /// without it; see make_faint().
  double faint_speech = 0.0;
  /// Share of training examples in which the other person speaks too, louder or fainter by up to
  /// 6 dB; box, position and dry speech stay those of the one. Not for near_microphone.
  double second_voices = 0.0;
  bool separate = true;                                        ///< take the ambient sound out again
  AmbientSeparation separation = AmbientSeparation::bandpass;  ///< and how
  /// Give recordings the near microphone's sound for dry speech (ReplaySampler::near_voice()).
  bool near_voice = false;
  std::size_t validation_pairs = 256;  ///< of the frozen list, evenly spread; 0 takes all
  std::size_t cache_bytes = 0;
  /// Called for each example that cannot be made, which is then left out; without it that ends
  /// training.
  std::function<void(const std::string&)> on_bad;
};

/// Makes an example of a sample; any thread may call it.
using PairEncoder = std::function<TrainingExample(const PairSample&)>;

/// Pairs of viewpoints in the SoundSpaces layout: random clip, pair, speaker and window of `train`
/// of all folders; of `val` of the first one the frozen pair list, drawn where there is none.
class PairExamples : public ExampleLoader {
 public:
  /// @throws InputError if the data set or its pair list is missing or malformed
  PairExamples(PairOptions options, PairEncoder encode);
  ~PairExamples() override;

  [[nodiscard]] TrainingExample training(std::uint64_t number) const override;
  [[nodiscard]] std::size_t validations() const override;
  [[nodiscard]] std::optional<TrainingExample> validation(std::size_t index) const override;

  /// The sample that training(number) encodes.
  /// @throws InputError if too few pairs are within the limits of the options, or files are bad
  [[nodiscard]] PairSample training_sample(std::uint64_t number) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Pairs of cameras of Replay-NVAS: random clip and pair of `train`, always the first second, as
/// the released loader takes it; of `val` the pairs that the released draw gives. With
/// Alignment::gcc_phat the source is moved by the delay found against the target, as the released
/// loader does, in validation too; with Alignment::none it is not.
class ReplayExamples : public ExampleLoader {
 public:
  /// @throws InputError if the data set is missing or malformed, or an option asks for what
  ///         recordings do not tell (responses, room noise, other speech), for another window, or
  ///         for spoilt views
  ReplayExamples(PairOptions options, PairEncoder encode);
  ~ReplayExamples() override;

  [[nodiscard]] TrainingExample training(std::uint64_t number) const override;
  [[nodiscard]] std::size_t validations() const override { return validation_.size(); }
  [[nodiscard]] std::optional<TrainingExample> validation(std::size_t index) const override;

 private:
  [[nodiscard]] PairSample sample(const ReplaySampler& sampler, const ReplayClip& clip,
                                  const ReplayChoice& choice) const;
  [[nodiscard]] PairSample training_sample(std::uint64_t number, std::uint64_t attempt) const;

  PairOptions options_;
  PairEncoder encode_;
  std::unique_ptr<ToldBoxes> boxes_;
  ReplayDataset train_;
  ReplayDataset val_;
  ReplaySampler train_sampler_;
  ReplaySampler val_sampler_;
  std::vector<std::pair<const ReplayClip*, ReplayChoice>> validation_;
};

/// PairExamples or ReplayExamples, as the data set is.
/// @throws InputError as these do
[[nodiscard]] std::unique_ptr<ExampleLoader> pair_examples(PairOptions options, PairEncoder encode);

/// So many examples in a row that cannot be made end training: the whole data set is bad.
inline constexpr std::uint64_t kMostBadExamples = 100;

/// `count` of `size` numbers, evenly spread; all of them if count is 0.
[[nodiscard]] std::vector<std::size_t> evenly_spread(std::size_t size, std::size_t count);

}  // namespace earpoint
