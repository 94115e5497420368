#include <earpoint/core/error.h>
#include <earpoint/model/weights.h>
#include <earpoint/synth/dsp_synthesizer.h>
#include <earpoint/synth/input_synthesizer.h>
#include <earpoint/synth/make_synthesizer.h>
#include <earpoint/synth/vigas_synthesizer.h>

namespace earpoint {

std::unique_ptr<AcousticSynthesizer> make_synthesizer(const std::string& model,
                                                      const SynthesizerOptions& options) {
  if (model == "input") return std::make_unique<InputSynthesizer>();
  if (model == "dsp") {
    return std::make_unique<DspSynthesizer>(options.hrtf, options.horizontal_fov_rad);
  }
  if (!std::filesystem::exists(model)) {
    throw InputError("--model " + model, "is neither a known name nor a file",
                     "use input, dsp or the path of a weight file");
  }
  return std::make_unique<ViGasSynthesizer>(read_vigas_weights(model), model, options.threads);
}

}  // namespace earpoint
