#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <earpoint/gtf/weights.h>
#include <earpoint/pose.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

struct SynthesizerOptions {
  std::optional<std::filesystem::path> hrtf;               ///< a SOFA file; default: the KEMAR set
  double horizontal_fov_rad = radians_from_degrees(90.0);  ///< of the source camera
  int threads = 1;
  /// Of a gtf network that knows two: 0 the mean, 1 natural. Nothing: natural, and any network.
  std::optional<double> texture;
  /// The network was trained for enhancement: what it answers is no place's sound, and has a level
  /// of its own.
  bool enhances = false;
};

/// @param model  `input`, `dsp`, or the path of a weight file
/// @throws InputError if it is neither, or the file is no network that this build can run or has no
///         textures to choose from
std::unique_ptr<AcousticSynthesizer> make_synthesizer(const std::string& model,
                                                      const SynthesizerOptions& options);

/// A model that was read once, to render clips with and to stream with.
struct OpenedModel {
  std::unique_ptr<AcousticSynthesizer> synthesizer;
  std::shared_ptr<const GtfWeights> gtf;  ///< null: it is no gtf network
};

/// As make_synthesizer().
[[nodiscard]] OpenedModel open_model(const std::string& model, const SynthesizerOptions& options);

}  // namespace earpoint
