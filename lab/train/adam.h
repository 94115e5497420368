#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <ATen/core/Tensor.h>

#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// How much of its running means Adam keeps at each step.
struct AdamDecay {
  double first = 0.9;
  double second = 0.999;
};

/// Adam without weight decay, epsilon 1e-8. A parameter's bias corrections count the steps that it
/// had a gradient at.
/// Source: Kingma and Ba, ICLR 2015, algorithm 1.
class Adam {
 public:
  /// @param parameters  share their memory with the network's
  explicit Adam(std::map<std::string, at::Tensor> parameters, AdamDecay decay = {});

  /// Moves every parameter against its gradient; those without one stay.
  void step(double learning_rate);

  [[nodiscard]] std::int64_t steps() const { return steps_; }

  /// Puts the running means of the gradients and of their squares beside the weights
  /// ("adam.first/NAME", "adam.second/NAME") and the steps into the metadata
  /// ("earpoint.adam_steps", and "earpoint.adam_steps/NAME" where they are fewer).
  void save(SafetensorsFile& file) const;

  /// Goes on from what save() put there.
  /// @param where  the file, for messages
  /// @throws InputError if something of it is missing or of another shape
  void load(const SafetensorsFile& file, std::string_view where);

 private:
  AdamDecay decay_;
  std::map<std::string, at::Tensor> parameters_;
  std::map<std::string, at::Tensor> first_;
  std::map<std::string, at::Tensor> second_;
  std::map<std::string, std::int64_t> taken_;  ///< steps of each: those that it had a gradient at
  std::int64_t steps_ = 0;
};

/// Scales all gradients down together so that their common length is at most `longest`.
/// @return the length before
double clip_gradients(const std::map<std::string, at::Tensor>& parameters, double longest);

}  // namespace earpoint
