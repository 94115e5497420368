#include "band_kernels.h"

#include <cmath>

#include <ATen/Parallel.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/empty_like.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>
#include <torch/csrc/autograd/custom_function.h>

#include <earpoint/core/error.h>

namespace earpoint {
namespace {

constexpr std::int64_t kEars = 2;

/// Sizes of one call.
struct Extent {
  std::int64_t past, future, tails, bands, clips, bins, frames;
  std::vector<int> edges;

  [[nodiscard]] std::int64_t shifts() const { return past + future + 1; }
  [[nodiscard]] std::int64_t taps() const { return shifts() + tails; }
  [[nodiscard]] std::int64_t padded() const { return frames + past + future; }
};

/// Calls body(kernel row, first value of what it weighs, output ear, bin) for all of one clip.
/// @param shifted  [2][bins][padded frames]
/// @param tails    [tails][2][bins][frames]
template <typename Body>
void for_every_tap(const Extent& e, const float* shifted, const float* tails, const Body& body) {
  std::int64_t row = 0;
  for (std::int64_t out = 0; out < kEars; ++out) {
    for (std::int64_t in = 0; in < kEars; ++in) {
      for (std::int64_t tap = 0; tap < e.taps(); ++tap) {
        for (std::int64_t band = 0; band < e.bands; ++band, ++row) {
          for (std::int64_t bin = e.edges[band]; bin < e.edges[band + 1]; ++bin) {
            const float* from =
                tap < e.shifts()
                    ? shifted + (in * e.bins + bin) * e.padded() + tap
                    : tails + (((tap - e.shifts()) * kEars + in) * e.bins + bin) * e.frames;
            body(row, from, out, bin);
          }
        }
      }
    }
  }
}

/// sum[t] += a[t] * b[t]
void add_product(float* __restrict sum, const float* __restrict a, const float* __restrict b,
                 std::int64_t count) {
  for (std::int64_t t = 0; t < count; ++t) sum[t] += a[t] * b[t];
}

class BandKernels : public torch::autograd::Function<BandKernels> {
 public:
  static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& kernels,
                            const at::Tensor& shifted, const at::Tensor& tails,
                            const Extent& extent) {
    context->saved_data["extent"] =
        std::vector<std::int64_t>{extent.past,  extent.future, extent.tails, extent.bands,
                                  extent.clips, extent.bins,   extent.frames};
    context->save_for_backward({shifted, tails});
    const at::Tensor rows = kernels.contiguous();
    at::Tensor sums = at::zeros({extent.clips, kEars, extent.bins, extent.frames});
    each_clip(extent, shifted, tails, [&](std::int64_t clip, const float* from, const float* past) {
      const float* weights = rows.data_ptr<float>() + clip * rows.stride(0);
      float* to = sums.data_ptr<float>() + clip * sums.stride(0);
      for_every_tap(extent, from, past,
                    [&](std::int64_t row, const float* x, std::int64_t out, std::int64_t bin) {
                      add_product(to + (out * extent.bins + bin) * extent.frames,
                                  weights + row * extent.frames, x, extent.frames);
                    });
    });
    return sums;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    const std::vector<std::int64_t> sizes = context->saved_data["extent"].toIntVector();
    const Extent extent{
        sizes[0], sizes[1], sizes[2], sizes[3],
        sizes[4], sizes[5], sizes[6], gtf_band_edges(static_cast<int>(sizes[3])).value()};
    const auto saved = context->get_saved_variables();
    const at::Tensor of_sums = gradients[0].contiguous();
    at::Tensor of_kernels =
        at::zeros({extent.clips, kEars * kEars * extent.taps() * extent.bands, extent.frames});
    each_clip(
        extent, saved[0], saved[1], [&](std::int64_t clip, const float* from, const float* past) {
          const float* slopes = of_sums.data_ptr<float>() + clip * of_sums.stride(0);
          float* to = of_kernels.data_ptr<float>() + clip * of_kernels.stride(0);
          for_every_tap(extent, from, past,
                        [&](std::int64_t row, const float* x, std::int64_t out, std::int64_t bin) {
                          add_product(to + row * extent.frames,
                                      slopes + (out * extent.bins + bin) * extent.frames, x,
                                      extent.frames);
                        });
        });
    return {of_kernels, {}, {}, {}};
  }

 private:
  template <typename Body>
  static void each_clip(const Extent& extent, const at::Tensor& shifted, const at::Tensor& tails,
                        const Body& body) {
    at::parallel_for(0, extent.clips, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t clip = begin; clip < end; ++clip) {
        body(clip, shifted.data_ptr<float>() + clip * shifted.stride(0),
             extent.tails == 0 ? nullptr : tails.data_ptr<float>() + clip * tails.stride(0));
      }
    });
  }
};

}  // namespace

at::Tensor decaying_mean(const at::Tensor& magnitudes, double time_constant_s) {
  const auto kept = static_cast<float>(
      std::exp(-double{GtfDescription::kHop} / (GtfDescription::kSampleRateHz * time_constant_s)));
  const at::Tensor from = magnitudes.detach().contiguous();
  at::Tensor means = at::empty_like(from);
  const std::int64_t frames = from.size(-1);
  const float* x = from.data_ptr<float>();
  float* m = means.data_ptr<float>();
  for (std::int64_t start = 0; start < from.numel(); start += frames) {
    float mean = 0.0F;
    for (std::int64_t t = start; t < start + frames; ++t) {
      mean = kept * mean + (1.0F - kept) * x[t];
      m[t] = mean;
    }
  }
  return means;
}

at::Tensor apply_band_kernels(const GtfDescription& d, const at::Tensor& magnitudes,
                              const at::Tensor& kernels) {
  EARPOINT_CHECK(magnitudes.device().is_cpu() && magnitudes.dim() == 4);
  const Extent extent{d.past_frames,
                      d.future_frames,
                      static_cast<std::int64_t>(d.tails_s.size()),
                      d.bands,
                      magnitudes.size(0),
                      magnitudes.size(2),
                      magnitudes.size(3),
                      gtf_band_edges(d.bands).value()};
  EARPOINT_CHECK(kernels.size(1) == kEars * kEars * extent.taps() * extent.bands &&
                 kernels.size(2) == extent.frames);
  const at::Tensor values = magnitudes.detach();
  std::vector<at::Tensor> tails;
  for (const double tail_s : d.tails_s) tails.push_back(decaying_mean(values, tail_s));
  return BandKernels::apply(
      kernels, at::constant_pad_nd(values, {extent.past, extent.future}).contiguous(),
      tails.empty() ? at::zeros({1}) : at::stack(tails, 1).contiguous(), extent);
}

}  // namespace earpoint
