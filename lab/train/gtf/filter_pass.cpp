#include "filter_pass.h"

#include "filter_kernels.h"
#include "trunk_kernels.h"
#include "vigas/stack_kernels.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>
#include <torch/csrc/autograd/custom_function.h>

#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;
using training::BinRows;
using training::BinSlopes;
using training::BinTurns;
using training::FrameExtent;
using training::kBins;
using training::KernelInputs;
using training::KernelShape;
using training::Product;

/// Sizes of one call.
struct Extent {
  KernelShape kernels;
  FrameExtent frames;
  std::vector<std::int64_t> band_of_bin;
  bool moves_ears;

  Extent(const GtfDescription& d, std::int64_t samples)
      : kernels{d.past_frames, d.future_frames, d.tails_s, gtf_band_edges(d.bands).value()},
        frames{samples},
        band_of_bin(kBins),
        moves_ears(d.ear_delays) {
    for (int band = 0; band < d.bands; ++band) {
      std::fill(band_of_bin.begin() + kernels.edges[band],
                band_of_bin.begin() + kernels.edges[band + 1], band);
    }
  }
};

float omega(std::int64_t bin) {
  return static_cast<float>(2.0 * kPi * GtfDescription::kSampleRateHz / GtfDescription::kFftSize) *
         static_cast<float>(bin);
}

/// The numbers of one clip in a tensor whose first axis is clips.
float* of_clip(const at::Tensor& tensor, std::int64_t clip) {
  return tensor.data_ptr<float>() + clip * tensor.stride(0);
}

BinTurns turns_of(const Extent& e, std::int64_t bin, const float* share, const float* source_s,
                  const float* target_s) {
  BinTurns turns{};
  turns.moves_ears = e.moves_ears;
  const auto bands = static_cast<std::int64_t>(e.kernels.bands());
  for (int ear = 0; ear < 2; ++ear) {
    turns.source_cosine[ear] = std::cos(omega(bin) * source_s[ear]);
    turns.source_sine[ear] = std::sin(omega(bin) * source_s[ear]);
    turns.target_cosine[ear] = std::cos(omega(bin) * target_s[ear]);
    turns.target_sine[ear] = std::sin(omega(bin) * target_s[ear]);
    turns.share[ear] = share[ear * bands + e.band_of_bin[bin]];
  }
  return turns;
}

/// A layer's outputs for all frames of a clip: [outputs][row].
void per_frame(const at::Tensor& weight, const float* still, const float* state, std::int64_t row,
               float* to) {
  const std::int64_t outputs = weight.size(0);
  const std::int64_t channels = weight.size(1);
  for (std::int64_t i = 0; i < outputs; ++i) std::fill_n(to + i * row, row, still[i]);
  const Product product{weight.data_ptr<float>(), channels, channels, state, row};
  training::add_products({&product, 1}, to, row, outputs, row);
}

/// Its gradient. @param turned  the state, [row][channels]
void per_frame_back(const at::Tensor& weight, const float* by_outputs, const float* turned,
                    std::int64_t row, float* by_weight, float* by_still, float* by_state) {
  const std::int64_t outputs = weight.size(0);
  const std::int64_t channels = weight.size(1);
  const Product product{by_outputs, row, row, turned, channels};
  training::add_products({&product, 1}, by_weight, channels, outputs, channels);
  training::add_row_sums({outputs, row}, by_outputs, row, by_still);
  training::add_outer_products(
      {weight.data_ptr<float>(), channels, by_outputs, row, outputs, channels, row, by_state});
}

BinRows rows_of(const Extent& e, std::int64_t bin, const float* spectrum, const float* filtered,
                const float* gains) {
  const std::ptrdiff_t plane = e.frames.plane();
  const std::ptrdiff_t at = bin * e.frames.row();
  return {
      {spectrum + at, spectrum + plane + at, spectrum + 2 * plane + at, spectrum + 3 * plane + at},
      {filtered + at, filtered + plane + at},
      {gains + at, gains + plane + at}};
}

class FilterPass : public torch::autograd::Function<FilterPass> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& state,
                            const at::Tensor& kernel_weight, const at::Tensor& kernel_still,
                            const at::Tensor& gain_weight, const at::Tensor& gain_still,
                            const at::Tensor& share, const at::Tensor& source_s,
                            const at::Tensor& target_s, const at::Tensor& spectrum,
                            const at::Tensor& magnitudes, const Extent* extent) {
    const Extent& e = *extent;
    const std::int64_t row = e.frames.row();
    const std::int64_t clips = state.size(0);
    at::Tensor mixed = at::empty({clips, kEars, 2, kBins, row});
    const at::Tensor filtered = at::empty({clips, kEars, kBins, row});
    const at::Tensor gains = at::empty({clips, kEars * kBins, row});
    const at::Tensor kernels = at::empty({e.kernels.rows(), row});
    const std::ptrdiff_t plane = e.frames.plane();
    for (std::int64_t clip = 0; clip < clips; ++clip) {
      per_frame(kernel_weight, of_clip(kernel_still, clip), of_clip(state, clip), row,
                kernels.data_ptr<float>());
      per_frame(gain_weight, of_clip(gain_still, clip), of_clip(state, clip), row,
                of_clip(gains, clip));
      const KernelInputs inputs(e.kernels, e.frames, of_clip(magnitudes, clip));
      training::apply_kernels(e.kernels, inputs, row, kernels.data_ptr<float>(),
                              of_clip(filtered, clip));
      for (std::int64_t bin = 0; bin < kBins; ++bin) {
        float* to = of_clip(mixed, clip) + bin * row;
        float* const planes[] = {to, to + plane, to + 2 * plane, to + 3 * plane};
        training::mix_bin(
            rows_of(e, bin, of_clip(spectrum, clip), of_clip(filtered, clip), of_clip(gains, clip)),
            turns_of(e, bin, of_clip(share, clip), of_clip(source_s, clip),
                     of_clip(target_s, clip)),
            row, planes);
      }
    }
    context->saved_data["extent"] = static_cast<std::int64_t>(e.frames.samples);
    context->saved_data["kernels"] =
        std::vector<std::int64_t>{e.kernels.past, e.kernels.future, e.kernels.bands()};
    context->saved_data["tails"] = e.kernels.tails_s;
    context->saved_data["ear_delays"] = e.moves_ears;
    context->save_for_backward({state, kernel_weight, gain_weight, share, source_s, target_s,
                                spectrum, magnitudes, filtered, gains});
    return mixed;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor& state = saved[0];
    const at::Tensor& kernel_weight = saved[1];
    const at::Tensor& gain_weight = saved[2];
    const at::Tensor& share = saved[3];
    const Extent e = saved_extent(context);
    const std::int64_t row = e.frames.row();
    const std::int64_t clips = state.size(0);
    const std::int64_t channels = state.size(1);
    const at::Tensor by_mixed = gradients[0].contiguous();
    at::Tensor by_state = at::zeros_like(state);
    at::Tensor by_kernel_weight = at::zeros_like(kernel_weight);
    at::Tensor by_kernel_still = at::zeros({clips, kernel_weight.size(0)});
    at::Tensor by_gain_weight = at::zeros_like(gain_weight);
    at::Tensor by_gain_still = at::zeros({clips, gain_weight.size(0)});
    at::Tensor by_share = at::zeros_like(share);
    at::Tensor by_source_s = at::zeros({clips, kEars});
    at::Tensor by_target_s = at::zeros({clips, kEars});

    const at::Tensor by_kernels = at::empty({e.kernels.rows(), row});
    const at::Tensor by_filtered = at::empty({kEars, kBins, row});
    const at::Tensor by_gains = at::empty({kEars * kBins, row});
    std::vector<float> turned(static_cast<std::size_t>(row * channels));
    for (std::int64_t clip = 0; clip < clips; ++clip) {
      for (std::int64_t bin = 0; bin < kBins; ++bin) {
        add_slopes(e, bin,
                   back_through_bin(e, saved, clip, bin, of_clip(by_mixed, clip),
                                    by_filtered.data_ptr<float>(), by_gains.data_ptr<float>()),
                   of_clip(by_share, clip), of_clip(by_source_s, clip), of_clip(by_target_s, clip));
      }
      const KernelInputs inputs(e.kernels, e.frames, of_clip(saved[7], clip));
      training::apply_kernels_back(e.kernels, inputs, row, by_filtered.data_ptr<float>(),
                                   by_kernels.data_ptr<float>());
      training::transpose(of_clip(state, clip), row, channels, row, turned.data(), channels);
      per_frame_back(kernel_weight, by_kernels.data_ptr<float>(), turned.data(), row,
                     by_kernel_weight.data_ptr<float>(), of_clip(by_kernel_still, clip),
                     of_clip(by_state, clip));
      per_frame_back(gain_weight, by_gains.data_ptr<float>(), turned.data(), row,
                     by_gain_weight.data_ptr<float>(), of_clip(by_gain_still, clip),
                     of_clip(by_state, clip));
    }
    return {by_state,
            by_kernel_weight,
            by_kernel_still,
            by_gain_weight,
            by_gain_still,
            by_share,
            by_source_s,
            by_target_s,
            {},
            {},
            {}};
  }

 private:
  static Extent saved_extent(AutogradContext* context) {
    const std::vector<std::int64_t> sizes = context->saved_data["kernels"].toIntVector();
    GtfDescription d;
    d.past_frames = static_cast<int>(sizes[0]);
    d.future_frames = static_cast<int>(sizes[1]);
    d.bands = static_cast<int>(sizes[2]);
    d.tails_s = context->saved_data["tails"].toDoubleVector();
    d.ear_delays = context->saved_data["ear_delays"].toBool();
    return {d, context->saved_data["extent"].toInt()};
  }

  static BinSlopes back_through_bin(const Extent& e, const variable_list& saved, std::int64_t clip,
                                    std::int64_t bin, const float* by_spectrum, float* by_filtered,
                                    float* by_gains) {
    const std::ptrdiff_t plane = e.frames.plane();
    const std::ptrdiff_t at = bin * e.frames.row();
    const float* const slopes[] = {by_spectrum + at, by_spectrum + plane + at,
                                   by_spectrum + 2 * plane + at, by_spectrum + 3 * plane + at};
    float* const filtered[] = {by_filtered + at, by_filtered + plane + at};
    float* const gains[] = {by_gains + at, by_gains + plane + at};
    return training::mix_bin_back(
        rows_of(e, bin, of_clip(saved[6], clip), of_clip(saved[8], clip), of_clip(saved[9], clip)),
        turns_of(e, bin, of_clip(saved[3], clip), of_clip(saved[4], clip), of_clip(saved[5], clip)),
        e.frames.row(), slopes, filtered, gains);
  }

  static void add_slopes(const Extent& e, std::int64_t bin, const BinSlopes& slopes,
                         float* by_share, float* by_source_s, float* by_target_s) {
    for (int ear = 0; ear < 2; ++ear) {
      by_share[ear * e.kernels.bands() + e.band_of_bin[bin]] += slopes.by_share[ear];
      by_source_s[ear] += omega(bin) * slopes.by_source_angle[ear];
      by_target_s[ear] += omega(bin) * slopes.by_target_angle[ear];
    }
  }
};

/// Pads axis `axis` with zeros to whole vectors.
at::Tensor filled_up(const at::Tensor& x, std::int64_t axis) {
  const std::int64_t size = x.size(axis);
  const std::int64_t missing =
      (training::kChannelStep - size % training::kChannelStep) % training::kChannelStep;
  if (missing == 0) return x.contiguous();
  return axis == 1 && x.dim() == 3 ? at::constant_pad_nd(x, {0, 0, 0, missing})
                                   : at::constant_pad_nd(x, {0, missing});
}

}  // namespace

at::Tensor filter_pass(const GtfDescription& description, const FilteredSound& sound,
                       const at::Tensor& state, const FrameLayer& kernels, const FrameLayer& gains,
                       const at::Tensor& share, const at::Tensor& source_delay_s,
                       const at::Tensor& target_delay_s) {
  const Extent extent(description, sound.samples);
  EARPOINT_CHECK(kernels.weight.size(0) == extent.kernels.rows() &&
                 gains.weight.size(0) == kEars * kBins && state.size(2) == extent.frames.row());
  return FilterPass::apply(filled_up(state, 1), filled_up(kernels.weight, 1),
                           kernels.still.contiguous(), filled_up(gains.weight, 1),
                           gains.still.contiguous(), share.contiguous(),
                           source_delay_s.contiguous(), target_delay_s.contiguous(), sound.spectrum,
                           sound.magnitudes, &extent);
}

}  // namespace earpoint
