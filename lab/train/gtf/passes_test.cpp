// The fused passes of gtf against the same formulas in LibTorch operations and their automatic
// gradients.
#include "filter_pass.h"
#include "frame_planes.h"
#include "phase_pass.h"
#include "sound_features.h"
#include "spectral_loss.h"
#include "trunk_pass.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/conv1d.h>
#include <ATen/ops/from_blob.h>
#include <ATen/ops/hamming_window.h>
#include <ATen/ops/istft.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/ones_like.h>
#include <ATen/ops/polar.h>
#include <ATen/ops/silu.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/stft.h>
#include <ATen/ops/view_as_complex.h>
#include <ATen/ops/view_as_real.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using D = GtfDescription;

constexpr std::int64_t kClips = 2;
// 20 frames: rows have 12 more floats of padding.
constexpr std::int64_t kSamples = 3123;
constexpr std::int64_t kFrames = 1 + kSamples / D::kHop;

at::Tensor noise(std::vector<std::int64_t> shape, double size, std::uint64_t seed) {
  RandomStream random(seed);
  at::Tensor values = at::zeros(shape);
  float* to = values.data_ptr<float>();
  for (std::int64_t i = 0; i < values.numel(); ++i) {
    to[i] = static_cast<float>(size * random.normal());
  }
  return values;
}

at::Tensor learned(const at::Tensor& values) { return values.clone().set_requires_grad(true); }

/// Float32 sums of up to some thousand terms in different orders: 1e-5 of the largest number.
void expect_same(const at::Tensor& found, const at::Tensor& right, const std::string& what,
                 double tolerance = 1e-5) {
  ASSERT_TRUE(found.defined() && right.defined()) << what;
  ASSERT_EQ(found.sizes(), right.sizes()) << what;
  const double size = right.abs().max().item<double>();
  EXPECT_GT(size, 0.0) << what << " is nothing";
  EXPECT_LT((found - right).abs().max().item<double>(), tolerance * size) << what;
}

at::Tensor torch_spectrum(const at::Tensor& sounds) {
  const at::Tensor rows =
      at::constant_pad_nd(sounds.flatten(0, 1), {D::kFftSize / 2, D::kFftSize / 2});
  return at::stft(rows, D::kFftSize, D::kHop, D::kFrameSamples,
                  at::hamming_window(D::kFrameSamples, true), false, true, true)
      .unflatten(0, {sounds.size(0), sounds.size(1)});
}

at::Tensor torch_sound(const at::Tensor& spectrum) {
  return at::istft(spectrum.flatten(0, 1), D::kFftSize, D::kHop, D::kFrameSamples,
                   at::hamming_window(D::kFrameSamples, true), true, false, true, kSamples)
      .unflatten(0, {spectrum.size(0), spectrum.size(1)});
}

at::Tensor magnitude_of(const at::Tensor& spectrum) {
  return (at::view_as_real(spectrum).square().sum(at::IntArrayRef({-1})) + 1e-8).sqrt();
}

/// Planes as the passes have them: [clips][2][real, imaginary][bins][frames].
at::Tensor planes_of(const at::Tensor& spectrum) {
  return at::view_as_real(spectrum).permute({0, 1, 4, 2, 3}).contiguous();
}

at::Tensor frames_of(const at::Tensor& planes) { return planes.narrow(-1, 0, kFrames); }

/// Runs the passes with one instruction set of those that this processor has.
class OnEveryInstructionSet : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};
class FramePlanes : public OnEveryInstructionSet {};
class TrunkPass : public OnEveryInstructionSet {};
class FilterPass : public OnEveryInstructionSet {};
class PhasePass : public OnEveryInstructionSet {};
class SpectralLoss : public OnEveryInstructionSet {};

std::string name_of_target(const testing::TestParamInfo<std::int64_t>& info) {
  return hwy::TargetName(info.param);
}

TEST_P(FramePlanes, HoldTheShortTimeSpectrum) {
  const at::Tensor sound = noise({kClips, 2, kSamples}, 0.1, 1);
  const at::Tensor planes = spectrum_planes(sound);
  expect_same(frames_of(planes), planes_of(torch_spectrum(sound)), "spectrum");
  EXPECT_EQ(planes.narrow(-1, kFrames, planes.size(-1) - kFrames).abs().max().item<float>(), 0.0F);
}

TEST_P(FramePlanes, BecomeTheSoundAgain) {
  const at::Tensor sound = noise({1, 2, kSamples}, 0.1, 1);
  const at::Tensor planes = spectrum_planes(sound);
  at::Tensor again = at::zeros_like(sound);
  training::synthesise({kSamples}, planes.data_ptr<float>(), again.data_ptr<float>());
  expect_same(again, sound, "sound");
}

TEST_P(FramePlanes, GradientsAreThoseOfTheTransforms) {
  const training::FrameExtent extent{kSamples};
  const at::Tensor sound = learned(noise({1, 2, kSamples}, 0.1, 1));
  const at::Tensor weights = noise({1, 2, 2, D::kBins, extent.row()}, 1.0, 2);
  (planes_of(torch_spectrum(sound)) * frames_of(weights)).sum().backward();
  at::Tensor by_sound = at::zeros_like(sound);
  training::analyse_back(extent, weights.data_ptr<float>(), by_sound.data_ptr<float>());
  expect_same(by_sound, sound.grad(), "by sound");

  const at::Tensor planes = learned(frames_of(weights));
  const at::Tensor of_samples = noise({1, 2, kSamples}, 1.0, 3);
  const at::Tensor spectrum = at::view_as_complex(planes.permute({0, 1, 3, 4, 2}).contiguous());
  (torch_sound(spectrum) * of_samples).sum().backward();
  at::Tensor by_planes = at::zeros_like(weights);
  training::synthesise_back(extent, of_samples.data_ptr<float>(), by_planes.data_ptr<float>());
  expect_same(frames_of(by_planes), planes.grad(), "by spectrum");
}

/// Numbers of channels that do not fill whole vectors.
TrunkTensors trunk_tensors(std::int64_t features, std::int64_t channels) {
  TrunkTensors tensors;
  tensors.input_weight = learned(noise({channels, features}, 0.2, 1));
  tensors.input_bias = learned(noise({channels}, 0.2, 2));
  std::uint64_t seed = 10;
  for (const std::int64_t dilation : {1, 4}) {
    tensors.weights.push_back(learned(noise({channels, channels, 3}, 0.2, seed++)));
    tensors.biases.push_back(learned(noise({channels}, 0.2, seed++)));
    tensors.films.push_back(learned(noise({kClips, 2 * channels}, 0.3, seed++)));
    tensors.dilations.push_back(dilation);
  }
  return tensors;
}

TEST_P(TrunkPass, ValueAndGradientAreThoseOfItsConvolutions) {
  constexpr std::int64_t kAhead = 2;
  const training::FrameExtent extent{kSamples};
  const at::Tensor features = noise({kClips, 10, extent.row()}, 1.0, 3);
  TrunkTensors ours = trunk_tensors(10, 12);
  const at::Tensor found = frames_of(trunk_pass(ours, features, kFrames, kAhead));

  TrunkTensors theirs = trunk_tensors(10, 12);
  const at::Tensor seen =
      at::constant_pad_nd(features.narrow(2, kAhead, kFrames - kAhead), {0, kAhead});
  at::Tensor x = at::silu(at::matmul(theirs.input_weight, seen) + theirs.input_bias.unsqueeze(1));
  for (std::size_t i = 0; i < theirs.weights.size(); ++i) {
    const std::int64_t dilation = theirs.dilations[i];
    const at::Tensor y =
        at::conv1d(at::constant_pad_nd(x, {2 * dilation, 0}), theirs.weights[i], theirs.biases[i],
                   at::IntArrayRef({1}), at::IntArrayRef({0}), at::IntArrayRef({dilation}));
    const std::vector<at::Tensor> film = theirs.films[i].chunk(2, 1);
    x = x + at::silu(y * (1 + film[0].unsqueeze(2)) + film[1].unsqueeze(2));
  }
  expect_same(found, x, "state");

  const at::Tensor weights = noise({kClips, 12, kFrames}, 1.0, 4);
  (found * weights).sum().backward();
  (x * weights).sum().backward();
  expect_same(ours.input_weight.grad(), theirs.input_weight.grad(), "by input weight");
  expect_same(ours.input_bias.grad(), theirs.input_bias.grad(), "by input bias");
  for (std::size_t i = 0; i < ours.weights.size(); ++i) {
    expect_same(ours.weights[i].grad(), theirs.weights[i].grad(), "by weight");
    expect_same(ours.biases[i].grad(), theirs.biases[i].grad(), "by bias");
    expect_same(ours.films[i].grad(), theirs.films[i].grad(), "by film");
  }
}

/// The arguments of filter_pass() except the sound.
struct FilterTensors {
  at::Tensor state, kernel_weight, kernel_still, gain_weight, gain_still, share, source_s, target_s;

  explicit FilterTensors(const D& d, std::int64_t row)
      : state(
            at::constant_pad_nd(noise({kClips, d.channels, kFrames}, 1.0, 20), {0, row - kFrames})),
        kernel_weight(noise({4 * d.taps() * d.bands, d.channels}, 0.05, 21)),
        kernel_still(noise({kClips, 4 * d.taps() * d.bands}, 0.3, 22)),
        // Some gains are beyond the limits at which they are clamped.
        gain_weight(noise({2 * D::kBins, d.channels}, 0.4, 23)),
        gain_still(noise({kClips, 2 * D::kBins}, 0.5, 24)),
        share(noise({kClips, 2, d.bands}, 1.0, 25).sigmoid()),
        source_s(noise({kClips, 2}, 4e-4, 26)),
        target_s(noise({kClips, 2}, 4e-4, 27)) {
    for (at::Tensor* tensor : all()) *tensor = learned(*tensor);
  }
  std::vector<at::Tensor*> all() {
    return {&state,      &kernel_weight, &kernel_still, &gain_weight,
            &gain_still, &share,         &source_s,     &target_s};
  }
};

at::Tensor delaying(const at::Tensor& delay_s) {
  const at::Tensor omega = at::arange(D::kBins, at::TensorOptions().dtype(at::kFloat)) *
                           (2.0 * kPi * D::kSampleRateHz / D::kFftSize);
  const at::Tensor angle = delay_s.unsqueeze(2) * omega * -1.0;
  return at::polar(at::ones_like(angle), angle).unsqueeze(3);
}

/// Kernels tap by tap. @param kernels  [clips][2][2][taps][bins][frames]
at::Tensor torch_filtered(const D& d, const at::Tensor& magnitudes, const at::Tensor& kernels) {
  const at::Tensor padded = at::constant_pad_nd(magnitudes, {d.past_frames, d.future_frames});
  std::vector<at::Tensor> inputs;
  for (int tap = 0; tap <= d.past_frames + d.future_frames; ++tap) {
    inputs.push_back(padded.narrow(3, tap, kFrames));
  }
  for (const double tail_s : d.tails_s) {
    const double kept = std::exp(-double{D::kHop} / (D::kSampleRateHz * tail_s));
    std::vector<at::Tensor> means;
    at::Tensor mean = at::zeros_like(magnitudes.select(3, 0));
    for (std::int64_t t = 0; t < kFrames; ++t) {
      mean = kept * mean + (1 - kept) * magnitudes.select(3, t);
      means.push_back(mean);
    }
    inputs.push_back(at::stack(means, 3));
  }
  const at::Tensor all = at::stack(inputs, 2).unsqueeze(1);  // [clips][1][2][taps][bins][frames]
  return (kernels * all).sum(at::IntArrayRef({2, 3}));
}

at::Tensor torch_filter(const D& d, const at::Tensor& source, const FilterTensors& x) {
  std::vector<std::int64_t> band_of_bin;
  const std::vector<int> edges = gtf_band_edges(d.bands).value();
  for (int band = 0; band < d.bands; ++band) band_of_bin.resize(edges[band + 1], band);
  const at::Tensor bands =
      at::from_blob(band_of_bin.data(), {D::kBins}, at::TensorOptions().dtype(at::kLong)).clone();
  const at::Tensor spectrum = torch_spectrum(source);
  const at::Tensor state = frames_of(x.state);
  const at::Tensor kernels = (at::matmul(x.kernel_weight, state) + x.kernel_still.unsqueeze(2))
                                 .reshape({kClips, 2, 2, d.taps(), d.bands, kFrames})
                                 .index_select(4, bands);
  const at::Tensor gains = (at::matmul(x.gain_weight, state) + x.gain_still.unsqueeze(2))
                               .unflatten(1, {2, D::kBins})
                               .clamp(-3, 2);
  const at::Tensor magnitudes =
      (torch_filtered(d, magnitude_of(spectrum), kernels).relu() + 1e-3) * gains.exp();
  const at::Tensor voice = (spectrum * delaying(-x.source_s)).sum(at::IntArrayRef({1}), true);
  const at::Tensor share = x.share.index_select(2, bands).unsqueeze(3);
  const at::Tensor rest =
      d.ear_delays ? spectrum * delaying(-x.source_s) * delaying(x.target_s) : spectrum;
  const at::Tensor mixed = voice * delaying(x.target_s) * share * 0.5 + rest * (1 - share);
  return magnitudes * mixed / magnitude_of(mixed);
}

void expect_the_formula(bool ear_delays) {
  D d;
  d.ear_delays = ear_delays;
  d.channels = 12;
  d.bands = 12;
  d.past_frames = 2;
  d.future_frames = 1;
  const at::Tensor source = noise({kClips, 2, kSamples}, 0.05, 30);
  const training::FrameExtent extent{kSamples};
  FilterTensors ours(d, extent.row());
  FilterTensors theirs(d, extent.row());
  const SoundFeatures heard = sound_features(d, source);
  const at::Tensor found = frames_of(
      filter_pass(d, {heard.spectrum, heard.magnitude, kSamples}, ours.state,
                  {ours.kernel_weight, ours.kernel_still}, {ours.gain_weight, ours.gain_still},
                  ours.share, ours.source_s, ours.target_s));
  const at::Tensor right = planes_of(torch_filter(d, source, theirs));
  expect_same(found, right, "spectrum", 2e-5);

  const at::Tensor weights = noise({kClips, 2, 2, D::kBins, kFrames}, 1.0, 31);
  (found * weights).sum().backward();
  (right * weights).sum().backward();
  const char* const names[] = {"state",      "kernel weight", "kernel still", "gain weight",
                               "gain still", "share",         "source delay", "target delay"};
  for (std::size_t i = 0; i < ours.all().size(); ++i) {
    // Delays: thousands of terms of either sign, multiplied by frequencies, almost cancel.
    expect_same(ours.all()[i]->grad(), theirs.all()[i]->grad(), names[i], i < 6 ? 1e-4 : 1e-3);
  }
}

TEST_P(FilterPass, ValueAndGradientAreThoseOfItsFormula) { expect_the_formula(false); }

TEST_P(FilterPass, ValueAndGradientAreThoseOfItsFormulaWithEarsMoved) { expect_the_formula(true); }

at::Tensor torch_rounds(const at::Tensor& start, int rounds) {
  const at::Tensor magnitude =
      (at::view_as_real(start).square().sum(at::IntArrayRef({-1})) + 1e-12).sqrt();
  at::Tensor turned = start;
  at::Tensor before = start;
  for (int round = 0; round < rounds; ++round) {
    const at::Tensor heard = torch_spectrum(torch_sound(turned));
    const at::Tensor pushed = heard + double{D::kPhaseMomentum} * (heard - before);
    turned = magnitude * pushed / magnitude_of(pushed);
    before = heard;
  }
  return torch_sound(turned);
}

TEST_P(PhasePass, ValueAndGradientAreThoseOfGriffinLim) {
  for (const int rounds : {0, 1, 3}) {
    const at::Tensor start = noise({kClips, 2, 2, D::kBins, kFrames}, 0.5, 50);
    const training::FrameExtent extent{kSamples};
    const at::Tensor ours = learned(at::constant_pad_nd(start, {0, extent.row() - kFrames}));
    const at::Tensor found = phase_pass(ours, rounds, kSamples);
    const at::Tensor theirs = learned(start);
    const at::Tensor right =
        torch_rounds(at::view_as_complex(theirs.permute({0, 1, 3, 4, 2}).contiguous()), rounds);
    expect_same(found, right, "sound", 1e-4);

    const at::Tensor weights = noise({kClips, 2, kSamples}, 1.0, 51);
    (found * weights).sum().backward();
    (right * weights).sum().backward();
    // In bins of almost no energy rounding decides the phase, which the rounds spread.
    expect_same(frames_of(ours.grad()), theirs.grad(), "by spectrum", 2e-3);
  }
}

at::Tensor torch_loss(const GtfLossWeights& weights, const at::Tensor& sound,
                      const at::Tensor& target) {
  const at::Tensor predicted = torch_spectrum(sound);
  const at::Tensor wanted = torch_spectrum(target);
  const at::Tensor found = magnitude_of(predicted);
  const at::Tensor right = magnitude_of(wanted);
  at::Tensor loss = (found - right).abs().mean() * 2;
  loss = loss + ((found + 0.02).log() - (right + 0.02).log()).abs().mean() * weights.log_magnitude;
  const at::Tensor floor = right.mean(at::IntArrayRef({1, 2, 3}), true) * 1e-2 + 1e-6;
  const auto spread = [&](const at::Tensor& magnitude) {
    const at::Tensor level = (magnitude + floor).log();
    const at::Tensor off = level - level.mean(at::IntArrayRef({3}), true);
    return (off.square().mean(at::IntArrayRef({3})) + 1e-4).sqrt();
  };
  loss = loss + (spread(found) - spread(right)).abs().mean() * weights.modulation;
  const auto cross = [](const at::Tensor& s) { return s.select(1, 0) * s.select(1, 1).conj(); };
  const at::Tensor strength = magnitude_of(cross(wanted));
  const at::Tensor distance =
      magnitude_of(cross(predicted) / magnitude_of(cross(predicted)) - cross(wanted) / strength);
  const at::Tensor weight = strength.sqrt();
  return loss + (weight * distance).sum() / weight.sum() * weights.phase_difference;
}

TEST_P(SpectralLoss, SharesAddUpToTheFormulaAndItsGradient) {
  const at::Tensor target = noise({kClips, 2, kSamples}, 0.05, 40);
  const at::Tensor start = noise({kClips, 2, kSamples}, 0.05, 41);
  for (const GtfLossWeights& weights :
       {GtfLossWeights{.log_magnitude = 0.1, .modulation = 0.5, .phase_difference = 0.2},
        GtfLossWeights{.log_magnitude = 0.0, .modulation = 0.0, .phase_difference = 0.0}}) {
    const at::Tensor theirs = learned(start);
    const at::Tensor right = torch_loss(weights, theirs, target);
    right.backward();

    const at::Tensor ours = learned(start);
    const at::Tensor wanted = spectrum_planes(target);
    const BatchShare share{0.5, loudness_of(wanted, kSamples)};
    double loss = 0.0;
    for (std::int64_t clip = 0; clip < kClips; ++clip) {
      const at::Tensor part =
          spectral_loss(weights, ours.narrow(0, clip, 1), wanted.narrow(0, clip, 1), share);
      part.backward();
      loss += part.item<double>();
    }
    // Float32 means of 20,000 values.
    EXPECT_NEAR(loss, right.item<double>(), 1e-5 * right.item<double>());
    // Where magnitudes are nearly equal rounding decides a sign: one bin in a few hundred.
    expect_same(ours.grad(), theirs.grad(), "by sound", 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(OnEveryInstructionSet, FramePlanes,
                         testing::ValuesIn(hwy::SupportedAndGeneratedTargets()), name_of_target);
INSTANTIATE_TEST_SUITE_P(OnEveryInstructionSet, TrunkPass,
                         testing::ValuesIn(hwy::SupportedAndGeneratedTargets()), name_of_target);
INSTANTIATE_TEST_SUITE_P(OnEveryInstructionSet, FilterPass,
                         testing::ValuesIn(hwy::SupportedAndGeneratedTargets()), name_of_target);
INSTANTIATE_TEST_SUITE_P(OnEveryInstructionSet, PhasePass,
                         testing::ValuesIn(hwy::SupportedAndGeneratedTargets()), name_of_target);
INSTANTIATE_TEST_SUITE_P(OnEveryInstructionSet, SpectralLoss,
                         testing::ValuesIn(hwy::SupportedAndGeneratedTargets()), name_of_target);

}  // namespace
}  // namespace earpoint
