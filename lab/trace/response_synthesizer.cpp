#include <earpoint/trace/response_synthesizer.h>

#include "ambisonics.h"
#include "early_field.h"
#include "late_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {
namespace {

ResponseShape make_shape(const RenderOptions& options) {
  ResponseShape shape{.sample_rate_hz = options.sample_rate_hz};
  shape.samples = static_cast<int>(std::lround(options.duration_s * options.sample_rate_hz));
  shape.fft_size =
      fast_fft_size(shape.samples + 2 * octave_bank_half_length(options.sample_rate_hz));
  return shape;
}

// Time of the first sound of a response, an arrival or late energy; infinity if there is none.
double first_sound_s(const PointResponse& response) {
  double first_s = std::numeric_limits<double>::infinity();
  if (!response.arrivals.empty()) first_s = response.arrivals.front().delay_s;
  for (int bin = 0; bin < response.late.bins(); ++bin) {
    const double begin_s = bin * response.late.bin_s();
    if (begin_s >= first_s) break;
    const BandArray energy = response.late.bin_energy(bin);
    if (std::ranges::any_of(energy, [](float band) { return band > 0.0F; })) return begin_s;
  }
  return first_s;
}

// Zero-phase filters ring ahead: silence up to 6 ms before the first sound, faded in over the next
// 3 ms.
void silence_before(const PointResponse& response, Waveform& waveform) {
  constexpr double kLead_s = 0.006;
  constexpr double kFade_s = 0.003;
  const double begin_s = first_sound_s(response) - kLead_s;
  for (int channel = 0; channel < waveform.channels(); ++channel) {
    const std::span<float> samples = waveform.channel(channel);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double into = (static_cast<double>(i) / waveform.sample_rate_hz() - begin_s) / kFade_s;
      if (into >= 1.0) break;
      samples[i] =
          into <= 0.0 ? 0.0F : samples[i] * static_cast<float>(0.5 - 0.5 * std::cos(kPi * into));
    }
  }
}

}  // namespace

struct ResponseSynthesizer::State {
  explicit State(const RenderOptions& options)
      : shape(make_shape(options)), late(shape, options.seed) {}

  ResponseShape shape;
  LateField late;
};

ResponseSynthesizer::ResponseSynthesizer(const RenderOptions& options) {
  EARPOINT_CHECK(options.sample_rate_hz > 0 && options.duration_s > 0.0);
  state_ = std::make_unique<const State>(options);
}
ResponseSynthesizer::~ResponseSynthesizer() = default;
ResponseSynthesizer::ResponseSynthesizer(ResponseSynthesizer&&) noexcept = default;
ResponseSynthesizer& ResponseSynthesizer::operator=(ResponseSynthesizer&&) noexcept = default;

Waveform ResponseSynthesizer::mono(const PointResponse& response, std::uint64_t stream) const {
  const ResponseShape& shape = state_->shape;
  Waveform waveform(1, shape.samples, shape.sample_rate_hz);
  state_->late.add_mono(response.late, response.arrivals, stream, waveform.channel(0));
  silence_before(response, waveform);
  return waveform;
}

Waveform ResponseSynthesizer::binaural(const PointResponse& response,
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
  silence_before(response, waveform);
  return waveform;
}

Waveform ResponseSynthesizer::ambisonic(const PointResponse& response,
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
  silence_before(response, waveform);
  return waveform;
}

}  // namespace earpoint
