#include <earpoint/render/make_synthesizer.h>

#include <utility>

#include <earpoint/error.h>
#include <earpoint/gtf/synthesizer.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/synthesis/dsp_synthesizer.h>
#include <earpoint/synthesis/input_synthesizer.h>
#include <earpoint/vam/synthesizer.h>
#include <earpoint/vam/weights.h>
#include <earpoint/vigas/synthesizer.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

[[noreturn]] void refuse_texture(const std::string& model) {
  throw InputError(model, "has one texture only", "do not choose a texture");
}

}  // namespace

std::unique_ptr<AcousticSynthesizer> make_synthesizer(const std::string& model,
                                                      const SynthesizerOptions& options) {
  return open_model(model, options).synthesizer;
}

OpenedModel open_model(const std::string& model, const SynthesizerOptions& options) {
  if (options.texture && (model == "input" || model == "dsp")) refuse_texture(model);
  if (model == "input") return {std::make_unique<InputSynthesizer>(), nullptr};
  if (model == "dsp") {
    return {std::make_unique<DspSynthesizer>(options.hrtf, options.horizontal_fov_rad), nullptr};
  }
  if (!std::filesystem::exists(model)) {
    throw InputError(model, "is neither a known name nor a file",
                     "use input, dsp, the name of a shipped model or the path of a weight file");
  }
  SafetensorsFile file = read_safetensors(model);
  const NetworkKind kind = network_kind(file, model);
  if (options.texture && kind != NetworkKind::gtf) refuse_texture(model);
  switch (kind) {
    case NetworkKind::gtf: {
      auto weights = std::make_shared<const GtfWeights>(gtf_weights(std::move(file), model));
      if (options.texture && !weights->description.texture) refuse_texture(model);
      auto synthesizer = std::make_unique<GtfSynthesizer>(
          weights, options.horizontal_fov_rad,
          GtfUse{.texture = options.texture.value_or(1.0), .limits_level = !options.enhances});
      return {std::move(synthesizer), std::move(weights)};
    }
    case NetworkKind::vam:
      return {std::make_unique<VamSynthesizer>(vam_weights(std::move(file), model), model,
                                               options.threads),
              nullptr};
    case NetworkKind::rt60_estimator:
      throw InputError(model, "estimates reverberation time and cannot render sound",
                       "use it for metrics");
    case NetworkKind::people:
      throw InputError(model, "detects people in pictures and cannot render sound",
                       "use it as a people detector");
    case NetworkKind::vigas:
      break;
  }
  return {std::make_unique<ViGasSynthesizer>(vigas_weights(std::move(file), model), model,
                                             options.threads),
          nullptr};
}

}  // namespace earpoint
