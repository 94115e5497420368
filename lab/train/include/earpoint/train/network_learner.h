#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include <earpoint/network/weights.h>
#include <earpoint/train/learner.h>
#include <earpoint/weights/safetensors.h>
#include <earpoint/weights/tensor.h>

namespace earpoint {

struct LearnedTensors;

/// A learner whose gradients LibTorch computes and whose optimizer is Adam. What derives from it
/// computes the loss.
class GradientLearner : public Learner {
 public:
  ~GradientLearner() override;

  /// The last gradient of the network's parameters; zero where the loss does not depend on one.
  [[nodiscard]] std::map<std::string, Tensor> gradients() const;

  void visit_gradients(const Visitor& visitor) override;
  void visit_statistics(const Visitor& visitor) override;

  /// One step of Adam along the last gradient.
  void apply_gradients(double learning_rate) override;

  /// Steps of Adam so far.
  [[nodiscard]] std::int64_t steps() const override;

  /// Everything that learning goes on from: weight_file(), with the optimizer's moments beside the
  /// weights ("adam.first/NAME", "adam.second/NAME") and its steps in the metadata
  /// ("earpoint.adam_steps").
  [[nodiscard]] SafetensorsFile checkpoint() const override;

 protected:
  GradientLearner();
  GradientLearner(GradientLearner&&) noexcept;
  GradientLearner& operator=(GradientLearner&&) noexcept;

  /// Sets the tensors to train. Every constructor of a derived class calls it once.
  void set_tensors(LearnedTensors tensors);

  /// Forgets the gradients of the last step.
  void forget_gradients();

  /// Goes on with the optimizer's state in a checkpoint(). @param where  the file, for messages
  /// @throws InputError if it holds none for these parameters
  void resume_optimizer(const SafetensorsFile& file, std::string_view where);

  /// Copies of all tensors of the network, as they are now.
  [[nodiscard]] std::map<std::string, Tensor> tensors() const;

 private:
  std::unique_ptr<LearnedTensors> learned_;
};

/// The same of a network with weight files.
template <class Description>
class NetworkLearner : public GradientLearner {
 public:
  [[nodiscard]] const Description& description() const { return description_; }

  /// A copy of the weights as they are now.
  [[nodiscard]] NetworkWeights<Description> weights() const {
    return {description_, tensors(), {}};
  }

  [[nodiscard]] SafetensorsFile weight_file() const override { return to_weight_file(weights()); }

 protected:
  explicit NetworkLearner(Description description) : description_(std::move(description)) {}

 private:
  Description description_;
};

}  // namespace earpoint
