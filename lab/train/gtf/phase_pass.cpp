#include "phase_pass.h"

#include "frame_planes.h"
#include "phase_kernels.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>
#include <torch/csrc/autograd/custom_function.h>

#include <earpoint/core/ears.h>

namespace earpoint {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;
using training::FrameExtent;
using training::PhaseRound;

class PhasePass : public torch::autograd::Function<PhasePass> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& spectrum,
                            std::int64_t rounds, std::int64_t samples) {
    const FrameExtent e{samples};
    const std::int64_t clips = spectrum.size(0);
    at::Tensor sound = at::empty({clips, kEars, samples});
    // The spectrum after each round's transform.
    const at::Tensor heard = at::empty({clips, rounds, e.spectrum()});
    std::vector<float> turned(static_cast<std::size_t>(e.spectrum()));
    for (std::int64_t clip = 0; clip < clips; ++clip) {
      const float* start = spectrum.data_ptr<float>() + clip * spectrum.stride(0);
      float* to = sound.data_ptr<float>() + clip * sound.stride(0);
      float* transform = heard.data_ptr<float>() + clip * heard.stride(0);
      training::synthesise(e, start, to);
      for (std::int64_t round = 0; round < rounds; ++round, transform += e.spectrum()) {
        training::analyse(e, to, transform);
        training::turn_to(e, {start, transform, before(e, start, transform, round)}, turned.data());
        training::synthesise(e, turned.data(), to);
      }
    }
    context->saved_data["samples"] = samples;
    context->save_for_backward({spectrum, heard});
    return sound;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const FrameExtent e{context->saved_data["samples"].toInt()};
    const std::int64_t rounds = saved[1].size(1);
    const at::Tensor by_sound = gradients[0].contiguous();
    at::Tensor by_spectrum = at::empty_like(saved[0]);
    const auto size = static_cast<std::size_t>(e.spectrum());
    std::vector<float> by_turned(size);
    std::vector<float> by_heard(size);
    std::vector<float> by_before(size);
    std::vector<float> by_samples(static_cast<std::size_t>(kEars * e.samples));
    for (std::int64_t clip = 0; clip < by_sound.size(0); ++clip) {
      const float* start = saved[0].data_ptr<float>() + clip * saved[0].stride(0);
      float* to = by_spectrum.data_ptr<float>() + clip * by_spectrum.stride(0);
      training::synthesise_back(e, by_sound.data_ptr<float>() + clip * by_sound.stride(0),
                                by_turned.data());
      std::fill_n(to, e.spectrum(), 0.0F);
      std::ranges::fill(by_heard, 0.0F);
      for (std::int64_t round = rounds - 1; round >= 0; --round) {
        const float* transform =
            saved[1].data_ptr<float>() + clip * saved[1].stride(0) + round * e.spectrum();
        training::turn_to_back(e, {start, transform, before(e, start, transform, round)},
                               by_turned.data(), {to, by_heard.data(), by_before.data()});
        training::analyse_back(e, by_heard.data(), by_samples.data());
        training::synthesise_back(e, by_samples.data(), by_turned.data());
        by_heard.swap(by_before);
      }
      // The start is both the spectrum before the first round and the input of that round.
      for (std::ptrdiff_t i = 0; i < e.spectrum(); ++i) to[i] += by_turned[i] + by_heard[i];
    }
    return {by_spectrum, {}, {}};
  }

 private:
  /// The spectrum one round earlier; before the first round it is the start.
  static const float* before(const FrameExtent& e, const float* start, const float* heard,
                             std::int64_t round) {
    return round == 0 ? start : heard - e.spectrum();
  }
};

}  // namespace

at::Tensor phase_pass(const at::Tensor& spectrum, int rounds, std::int64_t samples) {
  return PhasePass::apply(spectrum.contiguous(), rounds, samples);
}

}  // namespace earpoint
