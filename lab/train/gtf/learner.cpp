#include <earpoint/train/gtf_learner.h>

#include "graph.h"
#include "graph_tensors.h"
#include "learned_tensors.h"
#include "loss.h"
#include "parts.h"
#include "stft_loss.h"
#include "torch_tensor.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>

#include <earpoint/error.h>

namespace earpoint {

namespace {

/// Few clips, so that there are parts for all threads, but enough for an efficient pass.
/// Independent of the number of threads, so that results are too.
constexpr std::int64_t kClipsOfPart = 4;

GtfDescription described(GtfDescription description, const GtfLearnerOptions& options) {
  if (options.training_range) description.training_range = *options.training_range;
  return description;
}

}  // namespace

struct GtfLearner::State {
  State(const GtfWeights& weights, const GtfLearnerOptions& learner_options)
      : options(learner_options),
        estimator(frozen(learner_options)),
        graph(weights),
        magnitude(GtfDescription::kHop, at::kCPU) {}

  /// The estimator of the options, with fixed weights.
  [[nodiscard]] static std::optional<Rt60Graph> frozen(const GtfLearnerOptions& options) {
    const bool is_heard = options.loss.reverberation > 0 ||
                          (options.natural_loss && options.natural_loss->reverberation > 0);
    if (!is_heard) return std::nullopt;
    EARPOINT_CHECK(options.estimator.has_value());
    Rt60Graph graph(*options.estimator, at::kCPU);
    for (auto& [name, parameter] : graph.tensors.parameters) parameter.requires_grad_(false);
    return graph;
  }

  [[nodiscard]] static at::Tensor sounds(const TrainingBatch& batch,
                                         const std::vector<float>& values) {
    return sounds_to_torch(values, batch.clips, 2, at::kCPU);
  }

  [[nodiscard]] static at::Tensor values(const TrainingBatch& batch, const std::string& name,
                                         std::int64_t width) {
    const auto found = batch.inputs.find(name);
    EARPOINT_CHECK(found != batch.inputs.end());
    return to_torch(found->second, {batch.clips, width}, at::kCPU);
  }

  [[nodiscard]] static GtfInputs inputs_of(const GtfGraph& graph, const TrainingBatch& batch,
                                           double texture) {
    GtfInputs inputs;
    inputs.texture = texture;
    inputs.source = sounds(batch, batch.source);
    if (const std::int64_t size = graph.description().picture_px; size > 0) {
      inputs.picture = to_torch(batch.pictures, {batch.clips, 3, size, size}, at::kCPU);
    }
    inputs.box = values(batch, "speaker_box", 5);
    inputs.target_m = values(batch, "target_m", 3);
    inputs.target_yaw_rad = values(batch, "target_yaw_rad", 1);
    return inputs;
  }

  [[nodiscard]] static GtfOutput forward(GtfGraph& graph, const TrainingBatch& batch,
                                         double texture) {
    return graph.forward(inputs_of(graph, batch, texture));
  }

  /// Calls work(part, clips, graph) for all parts of the batch. Each part has a graph of its own.
  template <class Work>
  void each_part(const TrainingBatch& batch, const Work& work) {
    const std::int64_t parts = parts_of(batch);
    while (std::ssize(twins) < parts) twins.push_back(graph.twin());
    team.run(parts, [&](std::ptrdiff_t part) {
      const std::int64_t first = part * kClipsOfPart;
      const std::int64_t count = std::min(kClipsOfPart, batch.clips - first);
      work(part, clips_of(batch, first, count), twins[static_cast<std::size_t>(part)]);
    });
  }

  /// The same, one after the other, of what work(clips, graph) returns without gradients.
  template <class Number, class Work>
  std::vector<Number> without_gradients(const TrainingBatch& batch, const Work& work) {
    std::vector<std::vector<Number>> found(static_cast<std::size_t>(parts_of(batch)));
    each_part(batch, [&](std::ptrdiff_t part, const TrainingBatch& clips, GtfGraph& twin) {
      const at::NoGradGuard no_gradients;
      found[static_cast<std::size_t>(part)] = work(clips, twin);
    });
    std::vector<Number> all;
    for (const std::vector<Number>& some : found) all.insert(all.end(), some.begin(), some.end());
    return all;
  }

  /// Sums the gradients of the parts, in the order of the parts.
  void sum_gradients(std::int64_t parts) {
    const at::NoGradGuard no_gradients;
    for (auto& [name, parameter] : graph.parameters()) {
      at::Tensor sum;
      for (std::int64_t part = 0; part < parts; ++part) {
        const at::Tensor& gradient =
            twins[static_cast<std::size_t>(part)].parameters().at(name).grad();
        if (!gradient.defined()) continue;
        sum.defined() ? static_cast<void>(sum.add_(gradient)) : static_cast<void>(sum = gradient);
      }
      parameter.mutable_grad() = sum;
    }
  }

  [[nodiscard]] static std::int64_t parts_of(const TrainingBatch& batch) {
    return (batch.clips + kClipsOfPart - 1) / kClipsOfPart;
  }

  /// Parts alternate between the two textures.
  [[nodiscard]] bool is_natural(std::int64_t step, std::ptrdiff_t part) const {
    return options.natural_loss.has_value() && (step + part) % 2 == 1;
  }

  /// A part's loss and gradient, of the speakers' positions alone.
  double learn_places(const TrainingBatch& clips, double share, GtfGraph& twin) const {
    earpoint::forget_gradients(twin.parameters());
    GtfTruth truth;
    truth.speaker_m = values(clips, "speaker_m", 3);
    truth.speaker_heading = values(clips, "speaker_heading", 2);
    const at::Tensor loss =
        place_error(twin.locate(inputs_of(twin, clips, 1.0)), truth) * (options.loss.place * share);
    loss.backward();
    return loss.item<double>();
  }

  /// A part's loss and gradient, which stays in its graph.
  double learn_from(const TrainingBatch& clips, const at::Tensor& spectrum, const BatchShare& share,
                    bool is_natural, GtfGraph& twin) {
    const GtfLossWeights& loss_weights = is_natural ? *options.natural_loss : options.loss;
    earpoint::forget_gradients(twin.parameters());
    GtfTruth truth{
        sounds(clips, clips.target),        spectrum, {}, {}, values(clips, "speaker_m", 3),
        values(clips, "speaker_heading", 2)};
    if (loss_weights.decay > 0 || loss_weights.dry_voice > 0) {
      truth.dry = values(clips, "dry", truth.target.size(2));
    }
    if (loss_weights.dry_voice > 0) truth.dry_magnitude = dry_magnitudes(truth.dry);
    const at::Tensor loss = gtf_loss(loss_weights, forward(twin, clips, is_natural ? 1.0 : 0.0),
                                     truth, share, estimator ? &*estimator : nullptr);
    loss.backward();
    return loss.item<double>();
  }

  GtfLearnerOptions options;
  std::optional<Rt60Graph> estimator;
  GtfGraph graph;
  std::vector<GtfGraph> twins;  ///< of the parts of a batch
  PartTeam team;
  ShortTimeMagnitude magnitude;
};

GtfLearner::GtfLearner(const GtfWeights& weights, GtfLearnerOptions options)
    : NetworkLearner(described(weights.description, options)),
      state_(std::make_unique<State>(weights, options)) {
  EARPOINT_CHECK(weights.description.texture == options.natural_loss.has_value());
  EARPOINT_CHECK(weights.description.dry_voice || options.loss.dry_voice == 0.0);
  EARPOINT_CHECK(weights.description.geometry || options.place_steps == 0);
  GraphTensors tensors;
  tensors.parameters = state_->graph.parameters();
  LearnedTensors learned(std::move(tensors), {}, {.second = options.second_decay});
  learned.tables = state_->graph.buffers();
  learned.longest_gradient = options.longest_gradient;
  set_tensors(std::move(learned));
}
GtfLearner::~GtfLearner() = default;
GtfLearner::GtfLearner(GtfLearner&&) noexcept = default;
GtfLearner& GtfLearner::operator=(GtfLearner&&) noexcept = default;

std::vector<float> GtfLearner::predict(const TrainingBatch& batch, double texture) {
  return state_->without_gradients<float>(batch, [&](const TrainingBatch& clips, GtfGraph& graph) {
    return numbers_of<float>(State::forward(graph, clips, texture).sound);
  });
}

std::vector<float> GtfLearner::locate(const TrainingBatch& batch) {
  if (!description().geometry) return {};
  return state_->without_gradients<float>(batch, [](const TrainingBatch& clips, GtfGraph& graph) {
    return numbers_of<float>(graph.locate(State::inputs_of(graph, clips, 1.0)).position_m);
  });
}

std::vector<double> GtfLearner::errors(const TrainingBatch& batch) {
  return state_->without_gradients<double>(batch, [&](const TrainingBatch& clips, GtfGraph& graph) {
    return numbers_of<double>(magnitude_distance(state_->magnitude,
                                                 State::forward(graph, clips, 1.0).sound,
                                                 State::sounds(clips, clips.target)));
  });
}

double GtfLearner::compute_gradients(const TrainingBatch& batch) {
  State& state = *state_;
  const auto parts = static_cast<std::size_t>(State::parts_of(batch));
  std::vector<double> losses(parts);
  const auto share_of = [&](const TrainingBatch& clips) {
    return static_cast<double>(clips.clips) / static_cast<double>(batch.clips);
  };
  const auto finished = [&] {
    const OneThread one_thread;
    state.sum_gradients(static_cast<std::int64_t>(parts));
    return std::accumulate(losses.begin(), losses.end(), 0.0);
  };
  if (steps() < state.options.place_steps) {
    state.each_part(batch, [&](std::ptrdiff_t part, const TrainingBatch& clips, GtfGraph& graph) {
      losses[static_cast<std::size_t>(part)] = state.learn_places(clips, share_of(clips), graph);
    });
    return finished();
  }
  // The sum over all targets is needed before the first loss.
  std::vector<at::Tensor> spectra(parts);
  std::vector<double> loudness(parts);
  state.each_part(batch, [&](std::ptrdiff_t part, const TrainingBatch& clips, GtfGraph&) {
    const at::Tensor target = State::sounds(clips, clips.target);
    const auto at = static_cast<std::size_t>(part);
    spectra[at] = spectrum_planes(target);
    loudness[at] = loudness_of(spectra[at], target.size(2));
  });
  const double all_loudness = std::accumulate(loudness.begin(), loudness.end(), 0.0);
  state.each_part(batch, [&](std::ptrdiff_t part, const TrainingBatch& clips, GtfGraph& graph) {
    const BatchShare share{share_of(clips), all_loudness};
    const auto at = static_cast<std::size_t>(part);
    losses[at] =
        state.learn_from(clips, spectra[at], share, state.is_natural(steps(), part), graph);
  });
  return finished();
}

void GtfLearner::apply_gradients(double learning_rate) {
  const OneThread one_thread;
  NetworkLearner::apply_gradients(learning_rate);
}

GtfLearner GtfLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                       GtfLearnerOptions options) {
  GtfLearner learner(gtf_weights(file, where), options);
  learner.resume_optimizer(file, where);
  return learner;
}

}  // namespace earpoint
