#pragma once

#include <memory>
#include <span>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/vam/description.h>
#include <earpoint/vam/weights.h>

namespace earpoint {

/// A visual acoustic matching network, ready to run on the processor. The picture's part does not
/// depend on the target, so that several targets share it:
///
///   picture -> image_map()
///   waveform at the source, map, pose -> synthesize() -> waveform at the target
///
/// One caller at a time. A baseline: it allocates as it runs.
class Vam {
 public:
  /// @param threads  > 0
  Vam(VamWeights weights, int threads);
  ~Vam();
  Vam(Vam&&) noexcept;
  Vam& operator=(Vam&&) noexcept;

  [[nodiscard]] const VamDescription& description() const;

  /// @param picture  RGB of any size; resized as the network was trained, without smoothing
  /// @return  the ResNet's map, [map_channels()][image_tokens()]
  /// @throws std::logic_error if the picture is not RGB
  [[nodiscard]] std::vector<float> image_map(const Image& picture);
  /// @param picture  [3][height][width] of the network's size, 0 to 1
  [[nodiscard]] std::vector<float> image_map(std::span<const float> picture);

  /// The sound at the target.
  /// @param source  planar, [audio_channels][samples], samples > 0; zeros follow it up to a whole
  ///                token
  /// @param map     of the picture
  /// @param pose    [VamDescription::kPoseWidth], position and turn of the target
  /// @param output  planar, the size of `source`
  void synthesize(std::span<const float> source, std::span<const float> map,
                  std::span<const float> pose, std::span<float> output);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
