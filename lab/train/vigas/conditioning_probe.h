#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <ATen/core/Tensor.h>

#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A linear probe of the conditioning vector z during the training of ViGAS: it estimates where the
/// speaker is from the target, and by how much each ear's level changes. Its error trains the
/// fusion and the image trunk much faster than the loss of the rendered sound alone. No weight file
/// holds it.
class ConditioningProbe {
 public:
  /// Numbers in an example's input kPlace.
  static constexpr std::int64_t kPlaceWidth = 4;
  static constexpr const char* kPlace = "place";

  /// Starts with zeros, and is trained from the first step.
  ConditioningProbe(std::int64_t conditioning_width, std::int64_t audio_channels,
                    const at::Device& device);

  /// Sum over what is asked of the mean squared error.
  /// @param fused           z: [clips][conditioning width]
  /// @param place           [clips][kPlaceWidth], as place_of() gives it
  /// @param source, target  [clips][audio channels][samples]
  [[nodiscard]] at::Tensor error(const at::Tensor& fused, const at::Tensor& place,
                                 const at::Tensor& source, const at::Tensor& target) const;

  /// Puts its weights beside the network's.
  void save(SafetensorsFile& file) const;
  /// Goes on from what save() put there. @param where  the file, for messages
  /// @throws InputError if it is not there, or of another shape
  void load(const SafetensorsFile& file, std::string_view where);

  /// Under names that no network has.
  [[nodiscard]] const std::map<std::string, at::Tensor>& parameters() const { return parameters_; }

 private:
  std::map<std::string, at::Tensor> parameters_;
};

}  // namespace earpoint
