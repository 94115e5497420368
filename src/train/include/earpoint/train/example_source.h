#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/train/training_batch.h>

namespace earpoint {

/// Where a Trainer's examples come from. Any thread may call it.
class ExampleSource {
 public:
  virtual ~ExampleSource() = default;

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
  std::filesystem::path data;      ///< a folder that soundspaces_options() knows
  std::uint64_t seed = 1;          ///< of the draws in training
  std::ptrdiff_t samples = 16000;  ///< of a training window; validation takes a second
  bool any_speech = false;         ///< whoever speaks says what anyone of the split said
  bool mirror = true;              ///< half of the training examples are mirrored, left to right
  double spoilt_pictures = 0.0;    ///< share of training examples whose picture tells nothing
  double hidden_boxes = 0.0;       ///< share of training examples without the speaker's box
  PairTarget target = PairTarget::viewpoint;   ///< in validation too
  Alignment alignment = Alignment::responses;  ///< in training; validation pairs are aligned
  /// Level of room noise in both sounds, dB re full scale; near microphones hear none.
  std::optional<double> ambient_db;
  bool separate = true;                ///< take the ambient sound out again, by the high-pass
  std::size_t validation_pairs = 256;  ///< of the frozen list, evenly spread; 0 takes all
  std::size_t cache_bytes = 0;
  /// Called for each example that cannot be made, which is then left out; without it that ends
  /// training.
  std::function<void(const std::string&)> on_bad;
};

/// Pairs of viewpoints: random clip, pair, speaker and window of `train`; the frozen pair list of
/// `val`, "pairs-val.json".
class PairExamples : public ExampleSource {
 public:
  using Encoder = std::function<TrainingExample(const PairSample&)>;

  /// @param encode  makes an example of a sample; any thread may call it
  /// @throws InputError if the data set or its pair list is missing or malformed
  PairExamples(PairOptions options, Encoder encode);
  ~PairExamples() override;

  [[nodiscard]] TrainingExample training(std::uint64_t number) const override;
  [[nodiscard]] std::size_t validations() const override;
  [[nodiscard]] std::optional<TrainingExample> validation(std::size_t index) const override;

  /// The sample that training(number) encodes.
  [[nodiscard]] PairSample training_sample(std::uint64_t number) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
