#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include <earpoint/network/weights.h>
#include <earpoint/train/training_batch.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A network that is trained by gradients, with its optimizer: the interface of a Trainer.
class Learner {
 public:
  virtual ~Learner() = default;

  /// Computes the loss of a batch and its gradient by every parameter; replaces the last one.
  /// @return the loss, a mean over the batch
  virtual double compute_gradients(const TrainingBatch& batch) = 0;

  /// Looks at numbers in place, [elements of a tensor], and may change them.
  using Visitor = std::function<void(std::span<float>)>;

  /// Shows the last gradient of every parameter, in an order that depends on the network alone.
  virtual void visit_gradients(const Visitor& visitor) = 0;

  /// The same of what compute_gradients() changes besides: batch norms' running statistics.
  virtual void visit_statistics(const Visitor& visitor) = 0;

  /// One step of the optimizer along the last gradient.
  virtual void apply_gradients(double learning_rate) = 0;

  /// Steps of the optimizer so far.
  [[nodiscard]] virtual std::int64_t steps() const = 0;

  /// How far each clip's prediction is off, by the metric that chooses the best weights.
  [[nodiscard]] virtual std::vector<double> errors(const TrainingBatch& batch) = 0;

  /// The metric's name, e.g. "mag".
  [[nodiscard]] virtual std::string_view error_name() const = 0;

  /// The network as it is now, ready to be used.
  [[nodiscard]] virtual SafetensorsFile weight_file() const = 0;

  /// Everything that learning goes on from, the optimizer's state too.
  [[nodiscard]] virtual SafetensorsFile checkpoint() const = 0;
};

}  // namespace earpoint
