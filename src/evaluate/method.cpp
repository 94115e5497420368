#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/dataset/ambient.h>
#include <earpoint/dataset/sample.h>
#include <earpoint/evaluate/method.h>
#include <earpoint/spatial/dsp_renderer.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/synth/make_synthesizer.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;
constexpr int kEars = 2;
// Nearer than this a direction means nothing; the distance gain is clamped at 0.2 m anyway.
constexpr double kNearest_m = 0.01;

class InputMethod : public Method {
 public:
  Waveform render(const Question& question) override { return question.sample.source; }
};

Spherical seen_from(const Vector3& point_m) {
  Spherical spherical = spherical_from_cartesian(point_m);
  if (spherical.distance_m < kNearest_m) spherical = {.distance_m = kNearest_m};
  return spherical;
}

class DspMethod : public Method {
 public:
  explicit DspMethod(HrtfSet hrtf) : hrtf_(std::move(hrtf)) {}

  Waveform render(const Question& question) override {
    const PairSample& sample = question.sample;
    const Vector3 from_target =
        transform_point(inverse(sample.source_from_target), sample.speaker_m);
    return apply_filters(dsp_filters(hrtf_, seen_from(sample.speaker_m), seen_from(from_target)),
                         sample.source);
  }

 private:
  HrtfSet hrtf_;
};

class NetworkMethod : public Method {
 public:
  explicit NetworkMethod(std::unique_ptr<AcousticSynthesizer> synthesizer)
      : synthesizer_(std::move(synthesizer)) {}

  Waveform render(const Question& question) override {
    const PairSample& sample = question.sample;
    const bool takes_ambient = sample.ambient && synthesizer_->ambient_cutoff_hz() == 0.0;
    if (!takes_ambient) return render(sample, sample.source);
    return highpass(render(sample, sum(sample.source, *sample.ambient)), kSeparationCutoffHz);
  }

 private:
  static Waveform sum(Waveform a, const Waveform& b) {
    EARPOINT_CHECK(a.planar().size() == b.planar().size());
    for (std::size_t i = 0; i < a.planar().size(); ++i) a.planar()[i] += b.planar()[i];
    return a;
  }

  Waveform render(const PairSample& sample, const Waveform& heard) {
    const WindowShape shape = synthesizer_->window_shape(heard.sample_rate_hz());
    const std::ptrdiff_t samples = heard.samples();
    Waveform result(kEars, samples, heard.sample_rate_hz());
    for (std::ptrdiff_t start = 0; start < samples; start += shape.samples) {
      Observation observation{
          .sound = padded(heard, start - shape.context, shape.samples + 2 * shape.context),
          .picture = sample.picture,
          .speaker_box = sample.speaker_box.value_or(Box{}),
          .speaker_m = std::nullopt,
          .world_from_source = sample.world_from_source};
      synthesizer_->observe(observation);
      const Waveform part = synthesizer_->synthesize(sample.source_from_target);
      const std::ptrdiff_t count = std::min(shape.samples, samples - start);
      for (int ear = 0; ear < kEars; ++ear) {
        std::copy_n(part.channel(ear).begin(), count, result.channel(ear).begin() + start);
      }
    }
    return result;
  }

  /// [2][count] from sample `start`, zeros beyond the ends.
  static Waveform padded(const Waveform& sound, std::ptrdiff_t start, std::ptrdiff_t count) {
    Waveform window(sound.channels(), count, sound.sample_rate_hz());
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>(start, 0);
    const std::ptrdiff_t last = std::min(start + count, sound.samples());
    for (int c = 0; c < sound.channels() && first < last; ++c) {
      std::copy(sound.channel(c).begin() + first, sound.channel(c).begin() + last,
                window.channel(c).begin() + (first - start));
    }
    return window;
  }

  std::unique_ptr<AcousticSynthesizer> synthesizer_;
};

}  // namespace

MethodEntry input_method() {
  return {.name = "input",
          .what = "the source's sound as it is",
          .is_oracle = false,
          .make = [] { return std::make_unique<InputMethod>(); },
          .fixes_sign = false};
}

MethodEntry dsp_method() {
  return {.name = "dsp",
          .what = "inverse and forward head filters, true speaker position",
          .is_oracle = false,
          .make = [hrtf = HrtfSet::load(kRate_hz)] { return std::make_unique<DspMethod>(hrtf); },
          .needs_speaker = true};
}

MethodEntry network_method(const std::string& name, const std::string& weights,
                           std::optional<double> texture) {
  SynthesizerOptions options;
  options.texture = texture;
  const auto make = [weights, options] { return make_synthesizer(weights, options); };
  const int rate_hz = make()->window_shape(kRate_hz).sample_rate_hz;
  if (rate_hz != kRate_hz) {
    throw InputError(weights,
                     fmt::format("works at {} Hz, the pairs are at {} Hz", rate_hz, kRate_hz));
  }
  return {.name = name, .what = weights, .is_oracle = false, .make = [make] {
            return std::make_unique<NetworkMethod>(make());
          }};
}

}  // namespace earpoint
