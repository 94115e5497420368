#include <earpoint/evaluate/method.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include <earpoint/dataset/ambient.h>
#include <earpoint/dataset/sample.h>
#include <earpoint/error.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render/render_in_memory.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

class InputMethod : public Method {
 public:
  Waveform render(const Question& question) override { return question.sample.source; }
};

Waveform sum(Waveform a, const Waveform& b) {
  EARPOINT_CHECK(a.planar().size() == b.planar().size());
  for (std::size_t i = 0; i < a.planar().size(); ++i) a.planar()[i] += b.planar()[i];
  return a;
}

/// Makes synthesizers for pictures of a horizontal field of view.
using SynthesizerMaker = std::function<std::unique_ptr<AcousticSynthesizer>(double)>;

SynthesizerMaker maker_of(const std::string& model, const SynthesizerOptions& options) {
  return [model, options](double fov_rad) {
    SynthesizerOptions seen = options;
    seen.horizontal_fov_rad = fov_rad;
    return make_synthesizer(model, seen);
  };
}

/// A shipped renderer, in memory.
class ShippedMethod : public Method {
 public:
  ShippedMethod(SynthesizerMaker make, bool is_told_speaker)
      : make_(std::move(make)), is_told_speaker_(is_told_speaker) {}

  Waveform render(const Question& question) override {
    const PairSample& sample = question.sample;
    AcousticSynthesizer& synthesizer = synthesizer_for(sample.horizontal_fov_rad);
    const bool takes_ambient =
        sample.ambient && !is_told_speaker_ && synthesizer.ambient_cutoff_hz() == 0.0;
    if (!takes_ambient) return render(sample, sample.source, synthesizer);
    return highpass(render(sample, sum(sample.source, *sample.ambient), synthesizer),
                    kSeparationCutoffHz);
  }

 private:
  AcousticSynthesizer& synthesizer_for(double horizontal_fov_rad) {
    auto& synthesizer = synthesizers_[horizontal_fov_rad];
    if (!synthesizer) synthesizer = make_(horizontal_fov_rad);
    return *synthesizer;
  }

  [[nodiscard]] Waveform render(const PairSample& sample, const Waveform& heard,
                                AcousticSynthesizer& synthesizer) const {
    SoundInMemory source{.sound = heard,
                         .picture = sample.picture,
                         .speaker_box = sample.speaker_box,
                         .speaker_m = std::nullopt,
                         .world_from_source = sample.world_from_source};
    if (is_told_speaker_) source.speaker_m = sample.speaker_m;
    ClipRenderOptions options;
    options.ambient_cutoff_hz = 0.0;  // the sound is all primary, or is wanted whole
    options.limit = false;
    return render_in_memory(source, synthesizer, EarpointPath(sample.source_from_target), options);
  }

  SynthesizerMaker make_;
  std::map<double, std::unique_ptr<AcousticSynthesizer>> synthesizers_;  ///< by field of view
  bool is_told_speaker_;
};

}  // namespace

Waveform ask(Method& method, const MethodEntry& entry, const PairSample& sample,
             std::string_view scene, const PairTruth* truth) {
  PairSample seen = entry.hears_context ? sample : without_context(sample);
  seen.clean.reset();
  if (!entry.is_oracle) {
    seen.target = Waveform();
    truth = nullptr;
  }
  PairSample answer;
  answer.source = method.render({seen, scene, truth});
  answer.context = seen.context;
  return without_context(std::move(answer)).source;
}

MethodEntry input_method() {
  return {.name = "input",
          .what = "the source's sound as it is",
          .is_oracle = false,
          .make = [] { return std::make_unique<InputMethod>(); },
          .fixes_sign = false};
}

MethodEntry dsp_method() {
  (void)make_synthesizer("dsp", {});  // refuses a missing set of head filters now
  return {.name = "dsp",
          .what = "inverse and forward head filters, true speaker position",
          .is_oracle = false,
          .make = [] { return std::make_unique<ShippedMethod>(maker_of("dsp", {}), true); },
          .needs_speaker = true,
          .hears_context = true};
}

MethodEntry network_method(const std::string& name, const std::string& weights,
                           const SynthesizerOptions& options) {
  const auto make = maker_of(weights, options);
  const int rate_hz = make(options.horizontal_fov_rad)->window_shape(kRate_hz).sample_rate_hz;
  if (rate_hz != kRate_hz) {
    throw InputError(weights,
                     fmt::format("works at {} Hz, the pairs are at {} Hz", rate_hz, kRate_hz));
  }
  return {.name = name,
          .what = weights,
          .is_oracle = false,
          .make = [make] { return std::make_unique<ShippedMethod>(make, false); },
          .hears_context = true};
}

}  // namespace earpoint
