#include <earpoint/rt60/engine.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <earpoint/audio/stft.h>
#include <earpoint/error.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/resnet18.h>

namespace earpoint {
namespace {

kernels::ResNet18 make_resnet(const Rt60EstimatorWeights& weights, int bins, int frames,
                              int threads) {
  const kernels::TensorByName tensor = [&](const std::string& name) -> const Tensor& {
    return weights.at(name);
  };
  return {tensor, "feature_extraction", 1, bins, frames, threads};
}

/// The gain that brings the sound to that root mean square; 1 for silence.
float gain_to_rms(std::span<const float> sound, double rms) {
  double energy = 0.0;
  for (const float x : sound) energy += double{x} * x;
  if (energy == 0.0) return 1.0F;
  return static_cast<float>(rms / std::sqrt(energy / static_cast<double>(sound.size())));
}

}  // namespace

struct Rt60Estimator::State {
  State(const Rt60EstimatorWeights& weights, int threads)
      : description(weights.description),
        bins(stft.bins()),
        frames(stft.frames(Rt60Description::kWindowSamples)),
        resnet(make_resnet(weights, bins, frames, threads)),
        predictor(weights.at("predictor.0.weight").as<float>(),
                  weights.at("predictor.0.bias").as<float>()),
        picture(static_cast<std::size_t>(bins) * frames),
        map(static_cast<std::size_t>(resnet.channels()) * resnet.map_height() * resnet.map_width()),
        feature(resnet.channels()),
        scaled(Rt60Description::kWindowSamples) {}

  /// log(1 + |STFT|) as [bins][frames].
  void draw(std::span<const float> second) {
    const Spectrogram spectrum = stft.forward(second);
    for (int frame = 0; frame < frames; ++frame) {
      const auto values = spectrum.frame(frame);
      for (int bin = 0; bin < bins; ++bin) {
        picture[static_cast<std::size_t>(bin) * frames + frame] = std::log1p(std::abs(values[bin]));
      }
    }
  }

  Rt60Description description;
  Stft stft;
  int bins;
  int frames;
  kernels::ResNet18 resnet;
  kernels::Dense predictor;
  std::vector<float> picture;
  std::vector<float> map;
  std::vector<float> feature;
  std::vector<float> scaled;
};

Rt60Estimator::Rt60Estimator(const Rt60EstimatorWeights& weights, int threads)
    : state_(std::make_unique<State>(weights, threads)) {}
Rt60Estimator::~Rt60Estimator() = default;
Rt60Estimator::Rt60Estimator(Rt60Estimator&&) noexcept = default;
Rt60Estimator& Rt60Estimator::operator=(Rt60Estimator&&) noexcept = default;

const Rt60Description& Rt60Estimator::description() const { return state_->description; }

std::vector<double> Rt60Estimator::estimate_s(const Waveform& sound) {
  constexpr std::ptrdiff_t kWindow = Rt60Description::kWindowSamples;
  EARPOINT_CHECK(sound.sample_rate_hz() == Rt60Description::kSampleRateHz && !sound.empty());
  std::vector<double> seconds;
  for (int c = 0; c < sound.channels(); ++c) {
    const std::span<const float> channel = sound.channel(c);
    if (sound.samples() < kWindow) {
      std::vector<float> filled(channel.begin(), channel.end());
      filled.resize(kWindow);
      seconds.push_back(estimate_second_s(filled));
      continue;
    }
    double sum = 0.0;
    const std::ptrdiff_t windows = sound.samples() / kWindow;
    for (std::ptrdiff_t i = 0; i < windows; ++i) {
      sum += estimate_second_s(channel.subspan(static_cast<std::size_t>(i * kWindow), kWindow));
    }
    seconds.push_back(sum / static_cast<double>(windows));
  }
  return seconds;
}

double Rt60Estimator::estimate_second_s(std::span<const float> second) {
  State& state = *state_;
  EARPOINT_CHECK(second.size() == state.scaled.size());
  const std::optional<double> rms = state.description.input_rms;
  const float gain = rms ? gain_to_rms(second, *rms) : 1.0F;
  std::ranges::transform(second, state.scaled.begin(), [&](float x) { return gain * x; });
  state.draw(state.scaled);
  state.resnet.run(state.picture, state.map);
  const std::size_t places = state.map.size() / state.feature.size();
  for (std::size_t c = 0; c < state.feature.size(); ++c) {
    double sum = 0.0;
    for (std::size_t i = 0; i < places; ++i) sum += state.map[c * places + i];
    state.feature[c] = static_cast<float>(sum / static_cast<double>(places));
  }
  float estimate = 0.0F;
  state.predictor.apply(state.feature, std::span(&estimate, 1));
  return estimate;
}

std::span<const float> Rt60Estimator::feature() const { return state_->feature; }

}  // namespace earpoint
