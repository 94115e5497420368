#pragma once

#include "gtf_geometry.h"

#include <map>
#include <optional>
#include <string>

#include <ATen/core/Tensor.h>

#include <earpoint/model/gtf.h>

namespace earpoint {

/// What the network is given, clips along the first axis.
struct GtfInputs {
  at::Tensor source;          ///< [clips][2][samples]
  at::Tensor picture;         ///< [clips][3][size][size], 0 to 1; undefined if it does not look
  at::Tensor box;             ///< [clips][5]: 1 if seen, then x_min, y_min, x_max, y_max
  at::Tensor target_m;        ///< [clips][3]
  at::Tensor target_yaw_rad;  ///< [clips][1]
};

struct GtfOutput {
  at::Tensor sound;                     ///< [clips][2][samples]
  std::optional<SpeakerPlace> speaker;  ///< as estimated, in a network with geometry
};

/// The geometric time-frequency network as a graph of LibTorch operations over named tensors: the
/// names are those of its weight file.
class GtfGraph {
 public:
  GtfGraph(const GtfWeights& weights, const at::Device& device);

  /// The same network with gradients of its own: it shares the memory of parameters and tables.
  [[nodiscard]] GtfGraph twin() const;

  /// Keeps what a gradient needs unless gradients are off.
  GtfOutput forward(const GtfInputs& inputs);

  [[nodiscard]] const GtfDescription& description() const { return description_; }
  /// What is learned by gradients.
  [[nodiscard]] std::map<std::string, at::Tensor>& parameters() { return parameters_; }
  /// Tables of the head.
  [[nodiscard]] const std::map<std::string, at::Tensor>& buffers() const { return buffers_; }

 private:
  /// A sound in the short-time domain, and what is heard in it.
  struct Heard {
    at::Tensor spectrum;   ///< [clips][2][bins][frames], complex
    at::Tensor magnitude;  ///< the same shape, real
    at::Tensor features;   ///< [clips][frame features][frames]
    at::Tensor summary;    ///< [clips][summary features]
  };
  /// What the move does to the sound as a whole.
  struct Conditions {
    at::Tensor vector;  ///< [clips][conditioning width]
    MoveGeometry move;
  };

  Heard hear(const at::Tensor& sound) const;
  at::Tensor correlation_over_lags(const at::Tensor& cross) const;
  at::Tensor look(const at::Tensor& picture, const at::Tensor& box) const;
  SpeakerPlace locate(const at::Tensor& picture, const at::Tensor& box,
                      const at::Tensor& summary) const;
  Conditions condition(const GtfInputs& inputs, const Heard& heard,
                       std::optional<SpeakerPlace>& speaker) const;
  at::Tensor trunk(const at::Tensor& features, const at::Tensor& conditions) const;
  at::Tensor magnitudes(const Heard& heard, const at::Tensor& state,
                        const at::Tensor& conditions) const;
  at::Tensor phases(const Heard& heard, const Conditions& conditions) const;

  at::Tensor linear(const std::string& name, const at::Tensor& x) const;
  at::Tensor per_frame(const std::string& name, const at::Tensor& x) const;
  /// What changes with the frames and what does not: `name` of the trunk, `name.static`.
  at::Tensor modulated(const std::string& name, const at::Tensor& state,
                       const at::Tensor& conditions) const;
  const at::Tensor& parameter(const std::string& name) const { return parameters_.at(name); }

  GtfDescription description_;
  std::map<std::string, at::Tensor> parameters_;
  std::map<std::string, at::Tensor> buffers_;
  at::Tensor band_of_bin_;  // [bins]
  at::Tensor in_band_;      // [bins][bands]: 1 where a bin is in a band
  at::Tensor lag_cosine_;   // [bins][lags]
  at::Tensor lag_sine_;
};

}  // namespace earpoint
