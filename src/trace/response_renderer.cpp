#include "ambisonics.h"
#include "early_field.h"
#include "late_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <earpoint/core/error.h>
#include <earpoint/trace/response_renderer.h>

namespace earpoint {
namespace {

ResponseShape make_shape(const RenderOptions& options) {
  ResponseShape shape{.sample_rate_hz = options.sample_rate_hz};
  shape.samples = static_cast<int>(std::lround(options.duration_s * options.sample_rate_hz));
  shape.fft_size =
      fast_fft_size(shape.samples + 2 * octave_bank_half_length(options.sample_rate_hz));
  return shape;
}

}  // namespace

struct ResponseRenderer::State {
  explicit State(const RenderOptions& options)
      : shape(make_shape(options)), late(shape, options.seed) {}

  ResponseShape shape;
  LateField late;
};

ResponseRenderer::ResponseRenderer(const RenderOptions& options) {
  EARPOINT_CHECK(options.sample_rate_hz > 0 && options.duration_s > 0.0);
  state_ = std::make_unique<const State>(options);
}
ResponseRenderer::~ResponseRenderer() = default;
ResponseRenderer::ResponseRenderer(ResponseRenderer&&) noexcept = default;
ResponseRenderer& ResponseRenderer::operator=(ResponseRenderer&&) noexcept = default;

Waveform ResponseRenderer::mono(const PointResponse& response, std::uint64_t stream) const {
  const ResponseShape& shape = state_->shape;
  Waveform waveform(1, shape.samples, shape.sample_rate_hz);
  state_->late.add_mono(response.late, response.arrivals, stream, waveform.channel(0));
  return waveform;
}

Waveform ResponseRenderer::binaural(const PointResponse& response,
                                    const Quaternion& world_from_listener, const HrtfSet& hrtf,
                                    std::uint64_t stream) const {
  const ResponseShape& shape = state_->shape;
  EARPOINT_CHECK(hrtf.sample_rate_hz() == shape.sample_rate_hz);
  std::array<std::vector<float>, 2> ears;
  for (std::vector<float>& ear : ears) ear.assign(shape.samples, 0.0F);
  state_->late.add_binaural(response.late, world_from_listener, hrtf, stream, ears);
  add_early_binaural(shape, state_->late.bank(), response.arrivals, world_from_listener, hrtf,
                     ears);
  Waveform waveform(2, shape.samples, shape.sample_rate_hz);
  for (int ear = 0; ear < 2; ++ear) std::ranges::copy(ears[ear], waveform.channel(ear).begin());
  return waveform;
}

Waveform ResponseRenderer::ambisonic(const PointResponse& response,
                                     const Quaternion& world_from_listener, int order,
                                     std::uint64_t stream) const {
  constexpr int kHighestOrder = 7;
  EARPOINT_CHECK(order >= 0 && order <= kHighestOrder);
  const ResponseShape& shape = state_->shape;
  std::vector<std::vector<float>> channels(ambisonic_channels(order),
                                           std::vector<float>(shape.samples));
  state_->late.add_ambisonic(response.late, response.arrivals, world_from_listener, order, stream,
                             channels);
  Waveform waveform(ambisonic_channels(order), shape.samples, shape.sample_rate_hz);
  for (int c = 0; c < waveform.channels(); ++c) {
    std::ranges::copy(channels[c], waveform.channel(c).begin());
  }
  return waveform;
}

}  // namespace earpoint
