#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/training_range.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/train/network_learner.h>
#include <earpoint/train/training_batch.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// How much each term counts beside the mean difference of magnitudes, summed over the ears. That
/// alone makes sounds too quiet and leaves the ears' relation as it was. 0 leaves a term out.
struct GtfLossWeights {
  double log_magnitude = 0.05;     ///< mean | log |X| - log |Y| |, above the floor of a quiet room
  double level_difference = 0.01;  ///< of the level between the ears, dB
  double level = 0.01;             ///< of each ear's level, dB
  double squared_level = 0.0;      ///< of the square of that difference, dB²
  double modulation = 0.0;         ///< of the spread of each bin's level over time, nepers
  double decay = 0.0;              ///< of the decay of the response from dry speech, dB
  double reverberation = 0.0;      ///< of reverberation time as an estimator hears it, seconds
  double phase_difference = 0.05;  ///< of the phase between the ears
  double dry_voice = 0.0;          ///< of magnitudes of the dry voice, where the network tells them
  double place = 0.02;             ///< of the speaker's estimated direction, distance and heading

  friend bool operator==(const GtfLossWeights&, const GtfLossWeights&) = default;
};

struct GtfLearnerOptions {
  GtfLossWeights loss;  ///< of the only texture, or of the mean one
  /// Of the natural texture, which half of the clips are asked for; needed where the network is
  /// told a texture.
  std::optional<GtfLossWeights> natural_loss;
  /// Who hears reverberation times for the loss. Not who measures them: what learns to please one
  /// estimator must convince another.
  std::optional<Rt60EstimatorWeights> estimator;
  /// Of the data it learns from, for its weight file; nothing: that of the weights.
  std::optional<GtfTrainingRange> training_range;
  /// At the start, with the loss of the speaker's position alone and without sound: picture encoder
  /// and locator learn several times as many clips in that time. Needs a network with geometry.
  std::int64_t place_steps = 0;
  double longest_gradient = 1.0;  ///< gradients are scaled down to that length
  double second_decay = 0.98;     ///< of Adam: short, as loud clips come and go
};

/// Weights to start from: a network that gives back its input, as far as its phase term lets it,
/// with tables of that head. Kernels start as the identity, gains and phases as constants, all
/// other layers uniform within 1 / sqrt(inputs of a neuron). The same seed gives the same weights.
[[nodiscard]] GtfWeights initial_gtf_weights(const GtfDescription& description, const HrtfSet& head,
                                             std::uint64_t seed);

/// The same network with those parts of another description that it lacks: sight points, a texture,
/// a dry voice, ear delays, expected levels, phase rounds. Parts with tensors of their own change
/// nothing until they are trained.
/// @param seed  of the tensors that do not start at zero
/// @throws InputError if a part does not fit the network, e.g. sight points without a picture
[[nodiscard]] GtfWeights with_new_parts(GtfWeights weights, const GtfDescription& description,
                                        std::uint64_t seed);

/// A sample as the network is trained on it: beside its inputs it holds where the speaker is and
/// what is said, "dry".
[[nodiscard]] TrainingExample gtf_example(const GtfDescription& description,
                                          const PairSample& sample);

/// A geometric time-frequency network that learns by gradients, with its Adam optimizer. On the
/// processor only. Its weights are those of a weight file: what was trained renders at once.
class GtfLearner : public NetworkLearner<GtfDescription> {
 public:
  explicit GtfLearner(const GtfWeights& weights, GtfLearnerOptions options = {});
  ~GtfLearner() override;
  GtfLearner(GtfLearner&&) noexcept;
  GtfLearner& operator=(GtfLearner&&) noexcept;

  /// @param texture  0 the mean, 1 natural; means nothing to a network with one texture
  /// @return the sound at the targets, shape of batch.source
  [[nodiscard]] std::vector<float> predict(const TrainingBatch& batch, double texture = 1.0);
  /// @return where the speakers are taken to be, [clips][3]; empty without geometry
  [[nodiscard]] std::vector<float> locate(const TrainingBatch& batch);

  double compute_gradients(const TrainingBatch& batch) override;
  void apply_gradients(double learning_rate) override;

  /// The metric Mag of each clip, of the natural texture where there are two.
  [[nodiscard]] std::vector<double> errors(const TrainingBatch& batch) override;
  [[nodiscard]] std::string_view error_name() const override { return "mag"; }

  /// The learner that wrote `file`.
  /// @throws InputError if it is no such file
  [[nodiscard]] static GtfLearner from_checkpoint(const SafetensorsFile& file,
                                                  std::string_view where,
                                                  GtfLearnerOptions options = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
