#pragma once

#include "filter_pass.h"
#include "geometry.h"
#include "sound_features.h"

#include <map>
#include <optional>
#include <string>

#include <ATen/core/Tensor.h>

#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>

namespace earpoint {

/// What the network is given, clips along the first axis.
struct GtfInputs {
  at::Tensor source;          ///< [clips][2][samples]
  at::Tensor picture;         ///< [clips][3][size][size], 0 to 1; undefined if it does not look
  at::Tensor box;             ///< [clips][5]: 1 if seen, then x_min, y_min, x_max, y_max
  at::Tensor target_m;        ///< [clips][3]
  at::Tensor target_yaw_rad;  ///< [clips][1]
  double texture = 1.0;       ///< of all clips, where the network is told it
};

struct GtfOutput {
  at::Tensor sound;                     ///< [clips][2][samples]
  std::optional<SpeakerPlace> speaker;  ///< as estimated, in a network with geometry
  at::Tensor dry_magnitude;  ///< [clips][bins][frames]: of the dry voice, in one that tells it
};

/// The geometric time-frequency network as a graph of LibTorch operations and fused passes over
/// named tensors: the names are those of its weight file. On the processor.
class GtfGraph {
 public:
  explicit GtfGraph(const GtfWeights& weights);

  /// The same network with gradients of its own: it shares the memory of parameters and tables.
  [[nodiscard]] GtfGraph twin() const;

  /// Keeps what a gradient needs unless gradients are off.
  GtfOutput forward(const GtfInputs& inputs);

  /// The estimate of the speaker's position alone, a small part of the work. Needs a network with
  /// geometry.
  SpeakerPlace locate(const GtfInputs& inputs);

  [[nodiscard]] const GtfDescription& description() const { return description_; }
  /// What is learned by gradients.
  [[nodiscard]] std::map<std::string, at::Tensor>& parameters() { return parameters_; }
  /// Tables of the head.
  [[nodiscard]] const std::map<std::string, at::Tensor>& buffers() const { return buffers_; }

 private:
  /// What the move does to the sound as a whole.
  struct Conditions {
    at::Tensor vector;  ///< [clips][conditioning width]
    MoveGeometry move;
  };

  struct Seen {
    at::Tensor feature;  ///< [clips][picture width]; undefined if the network does not look
    at::Tensor map;      ///< [clips][channels][side][side]: after kSightLayer layers
  };
  Seen encode(const at::Tensor& picture, const at::Tensor& box) const;
  at::Tensor encode_towards(const at::Tensor& map, const at::Tensor& target_m) const;
  /// Without the box if the network is not told it.
  [[nodiscard]] at::Tensor told_box(const GtfInputs& inputs) const;
  [[nodiscard]] Seen look(const GtfInputs& inputs) const;
  SpeakerPlace locate(const at::Tensor& picture, const at::Tensor& box,
                      const at::Tensor& summary) const;
  Conditions condition(const GtfInputs& inputs, const SoundFeatures& heard,
                       std::optional<SpeakerPlace>& speaker) const;
  at::Tensor trunk(const SoundFeatures& heard, const at::Tensor& conditions) const;
  at::Tensor dry_magnitude(const SoundFeatures& heard, const at::Tensor& state,
                           const at::Tensor& conditions) const;
  at::Tensor filter(const SoundFeatures& heard, const at::Tensor& state,
                    const Conditions& conditions) const;

  at::Tensor linear(const std::string& name, const at::Tensor& x) const;
  /// What changes with the frames and what does not: `name` of the trunk, `name.static`.
  FrameLayer modulated(const std::string& name, const at::Tensor& conditions) const;
  const at::Tensor& parameter(const std::string& name) const { return parameters_.at(name); }

  GtfDescription description_;
  std::map<std::string, at::Tensor> parameters_;
  std::map<std::string, at::Tensor> buffers_;
};

}  // namespace earpoint
