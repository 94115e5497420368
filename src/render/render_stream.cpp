#include <earpoint/render/render_stream.h>

#include "delay_line.h"
#include "stream_gains.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <earpoint/audio/butterworth.h>
#include <earpoint/audio/energy.h>
#include <earpoint/audio/peak_limiter.h>
#include <earpoint/audio/stream_rate.h>
#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/level.h>
#include <earpoint/gtf/view.h>
#include <earpoint/render/stream_rates.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint {
namespace {

using D = GtfDescription;

constexpr double kHop_s = double{D::kHop} / D::kSampleRateHz;

/// How a stream of any rate is cut so that every part is a whole number of samples at both rates.
struct StreamShape {
  explicit StreamShape(int sample_rate_hz) : rate_hz(sample_rate_hz) {
    check_stream_rate(rate_hz);
    hops = rate_hz % 100 == 0 ? 1 : 2;
    model = hops * D::kHop;
    native = native_of(model);
  }

  [[nodiscard]] std::ptrdiff_t native_of(std::ptrdiff_t model_samples) const {
    return model_samples * rate_hz / D::kSampleRateHz;
  }
  /// The least number of the model's samples, not less than the given one, that lasts a whole
  /// number of samples at the stream's rate too.
  [[nodiscard]] std::ptrdiff_t whole(std::ptrdiff_t model_samples) const {
    const std::ptrdiff_t unit = D::kSampleRateHz / std::gcd(D::kSampleRateHz, rate_hz);
    return (model_samples + unit - 1) / unit * unit;
  }

  int rate_hz;
  std::ptrdiff_t hops = 1;    ///< of the network in a part
  std::ptrdiff_t model = 0;   ///< samples of a part at the model's rate
  std::ptrdiff_t native = 0;  ///< samples of a part at the stream's rate
};

/// Resampling down and up must take a whole number of samples in all, because its result is
/// subtracted from the recording to get the high band.
double rate_delay_s(const StreamShape& shape) {
  if (shape.rate_hz == D::kSampleRateHz) return 0.0;
  constexpr double kDelay_s = 0.005;
  return std::ceil(2.0 * kDelay_s * shape.rate_hz) / (2.0 * shape.rate_hz);
}

/// A network at the beginning of a stream, so that its latency is known.
Gtf started(const GtfWeights& weights, const RenderStream::Options& options) {
  Gtf network(weights);
  if (options.texture) network.ask_for_texture(*options.texture);
  network.start({}, options.phase_rounds);
  return network;
}

/// Splits one ear's sound into what bypasses the network and what enters it.
struct Split {
  SectionFilter ambient;
  SectionFilter primary;
};

/// Empty if the network takes the whole sound.
std::vector<Split> splits_of(const D& description) {
  const double cutoff_hz = description.highpass_cutoff_hz.value_or(0.0);
  if (cutoff_hz <= 0.0) return {};
  const Crossover crossover = linkwitz_riley(cutoff_hz, D::kSampleRateHz);
  const Split split{SectionFilter(crossover.low), SectionFilter(crossover.high)};
  return {split, split};
}

}  // namespace

/// A part of the stream is resampled to the model's rate, runs through the network hop by hop and
/// is resampled back. The band above the model's rate is delayed by as much.
struct RenderStream::State {
  State(const GtfWeights& weights, const Options& options_in)
      : options(options_in),
        shape(options.sample_rate_hz),
        network(started(weights, options)),
        rates_late(std::lround(2.0 * rate_delay_s(shape) * shape.rate_hz)),
        model_late(shape.whole(network.latency_samples())),
        down(kEars, shape.rate_hz, D::kSampleRateHz, rate_delay_s(shape)),
        up_low(kEars, D::kSampleRateHz, shape.rate_hz, rate_delay_s(shape)),
        up(kEars, D::kSampleRateHz, shape.rate_hz, rate_delay_s(shape)),
        native_delay(kEars, rates_late),
        high_delay(kEars, shape.native_of(model_late)),
        source_delay(kEars, network.latency_samples()),
        ambient_delay(kEars, model_late),
        result_delay(kEars, model_late - network.latency_samples()),
        splits(splits_of(network.description())),
        level(kHop_s),
        band_gain(D::kSampleRateHz, kHop_s),
        limiter(kEars, shape.rate_hz) {
    for (std::vector<float>* buffer : {&in, &out, &low, &high}) {
      buffer->resize(static_cast<std::size_t>(kEars * shape.native));
    }
    model.resize(static_cast<std::size_t>(kEars * shape.model));
    mixed.resize(model.size());
    for (std::vector<float>* buffer : {&primary, &ambient, &result}) {
      buffer->resize(std::size_t{kEars} * D::kHop);
    }
    // The resamplers allocate their memory at their first part: run them on silence once.
    down.process(in, model);
    up_low.process(model, low);
    up.process(mixed, out);
    for (StreamRate* rate : {&down, &up_low, &up}) rate->reset();
  }

  void run_part();
  void split_hop(std::ptrdiff_t start);
  void run_hop(std::ptrdiff_t start);
  void add_high_band();

  Options options;
  StreamShape shape;
  Gtf network;
  std::ptrdiff_t rates_late;  ///< delay of both resamplings, at the stream's rate
  std::ptrdiff_t model_late;  ///< delay of the network, rounded up to a whole one at that rate

  StreamRate down;
  StreamRate up_low;
  StreamRate up;
  DelayLine native_delay;
  DelayLine high_delay;
  DelayLine source_delay;
  DelayLine ambient_delay;
  DelayLine result_delay;
  std::vector<Split> splits;  // one per ear, or none
  StreamLevel level;
  StreamBandGain band_gain;
  PeakLimiter limiter;

  Pose source_from_target;
  std::optional<Vector3> mouth_m;
  bool has_heard = false;

  // Of a part, planar; the first four at the stream's rate.
  std::vector<float> in;
  std::vector<float> out;
  std::vector<float> low;
  std::vector<float> high;
  std::vector<float> model;
  std::vector<float> mixed;
  std::ptrdiff_t filled = 0;  ///< samples of `in`, and read ones of `out`
  // Of a hop.
  std::vector<float> primary;
  std::vector<float> ambient;
  std::vector<float> result;

  // Gains at the end of the last hop.
  float level_gain = 1.0F;
  std::array<float, kEars> high_gains{1.0F, 1.0F};
  std::array<float, kEars> next_high_gains{1.0F, 1.0F};
};

void RenderStream::State::split_hop(std::ptrdiff_t start) {
  for (std::size_t e = 0; e < kEars; ++e) {
    const float* const samples = model.data() + e * shape.model + start;
    if (splits.empty()) {
      std::copy_n(samples, D::kHop, primary.begin() + e * D::kHop);
      continue;
    }
    for (std::ptrdiff_t i = 0; i < D::kHop; ++i) {
      primary[e * D::kHop + i] = static_cast<float>(splits[e].primary.process(samples[i]));
      ambient[e * D::kHop + i] = static_cast<float>(splits[e].ambient.process(samples[i]));
    }
  }
}

void RenderStream::State::run_hop(std::ptrdiff_t start) {
  split_hop(start);
  network.set_pose(source_from_target, mouth_m);
  network.advance(primary, result);
  has_heard = true;
  source_delay.process(primary);

  const LevelBounds bounds = gtf_level_bounds(
      network.expected_gain(),
      gtf_level_tolerance(source_from_target, network.description().training_range),
      mouth_m.has_value());
  const float before = level_gain;
  level_gain = level.next(energy(primary), bounds, energy(result));
  for (std::size_t e = 0; e < kEars; ++e) {
    for (std::ptrdiff_t i = 0; i < D::kHop; ++i) {
      const float place = static_cast<float>(i + 1) / D::kHop;
      result[e * D::kHop + i] *= std::lerp(before, level_gain, place);
    }
  }
  next_high_gains = band_gain.next(primary, result);
  result_delay.process(result);
  ambient_delay.process(ambient);
  for (std::size_t e = 0; e < kEars; ++e) {
    for (std::ptrdiff_t i = 0; i < D::kHop; ++i) {
      mixed[e * shape.model + start + i] = result[e * D::kHop + i] + ambient[e * D::kHop + i];
    }
  }
}

void RenderStream::State::add_high_band() {
  std::ranges::copy(in, high.begin());
  native_delay.process(high);
  for (std::size_t i = 0; i < high.size(); ++i) high[i] -= low[i];
  high_delay.process(high);
  for (std::size_t e = 0; e < kEars; ++e) {
    for (std::ptrdiff_t i = 0; i < shape.native; ++i) {
      const float place = static_cast<float>(i + 1) / static_cast<float>(shape.native);
      out[e * shape.native + i] +=
          std::lerp(high_gains[e], next_high_gains[e], place) * high[e * shape.native + i];
    }
  }
  high_gains = next_high_gains;
}

void RenderStream::State::run_part() {
  for (float& sample : in) sample = std::isfinite(sample) ? sample : 0.0F;
  down.process(in, model);
  up_low.process(model, low);
  for (std::ptrdiff_t hop = 0; hop < shape.hops; ++hop) run_hop(hop * D::kHop);
  up.process(mixed, out);
  if (options.extend_band && shape.rate_hz != D::kSampleRateHz) add_high_band();
  if (options.limit) limiter.process_late(out);
}

RenderStream::RenderStream(const GtfWeights& weights, const Options& options)
    : state_(std::make_unique<State>(weights, options)) {
  see(nullptr, {});
}
RenderStream::~RenderStream() = default;
RenderStream::RenderStream(RenderStream&&) noexcept = default;
RenderStream& RenderStream::operator=(RenderStream&&) noexcept = default;

void RenderStream::see(const Image* picture, const std::optional<Box>& speaker_box) {
  State& s = *state_;
  const int size = s.network.description().picture_px;
  const GtfView view = gtf_view(size > 0 ? picture : nullptr, speaker_box,
                                s.options.horizontal_fov_rad, std::max(size, 1));
  s.network.set_picture(size > 0 ? std::span<const float>(view.picture) : std::span<const float>(),
                        view.speaker_box);
}

void RenderStream::place_speaker(const std::optional<Vector3>& mouth_m) {
  if (mouth_m) check_place(*mouth_m, "speaker");
  state_->mouth_m = mouth_m;
}

void RenderStream::move_to(const Pose& source_from_target) {
  check_pose(source_from_target, "earpoint");
  state_->source_from_target = source_from_target;
}

void RenderStream::process(std::array<std::span<const float>, 2> in,
                           std::array<std::span<float>, 2> out) {
  State& s = *state_;
  EARPOINT_CHECK(in[0].size() == in[1].size() && out[0].size() == in[0].size() &&
                 out[1].size() == in[0].size());
  const std::ptrdiff_t samples = std::ssize(in[0]);
  for (std::ptrdiff_t done = 0; done < samples;) {
    const std::ptrdiff_t count = std::min(samples - done, s.shape.native - s.filled);
    const auto place = [&](std::size_t e) {
      return static_cast<std::ptrdiff_t>(e) * s.shape.native + s.filled;
    };
    // Both are read before one is written: an ear of `out` may be the memory of either of `in`.
    for (std::size_t e = 0; e < kEars; ++e) {
      std::copy_n(in[e].begin() + done, count, s.in.begin() + place(e));
    }
    for (std::size_t e = 0; e < kEars; ++e) {
      std::copy_n(s.out.begin() + place(e), count, out[e].begin() + done);
    }
    done += count;
    s.filled += count;
    if (s.filled == s.shape.native) {
      s.run_part();
      s.filled = 0;
    }
  }
}

std::ptrdiff_t RenderStream::latency_samples() const {
  const State& s = *state_;
  return s.shape.native + s.rates_late + s.shape.native_of(s.model_late) +
         (s.options.limit ? s.limiter.latency_samples() : 0);
}

std::optional<Vector3> RenderStream::speaker_m() const {
  return state_->has_heard ? state_->network.speaker_m() : std::nullopt;
}

void RenderStream::reset() {
  State& s = *state_;
  s.network.start({}, s.options.phase_rounds);
  for (StreamRate* rate : {&s.down, &s.up_low, &s.up}) rate->reset();
  for (DelayLine* line :
       {&s.native_delay, &s.high_delay, &s.source_delay, &s.ambient_delay, &s.result_delay}) {
    line->reset();
  }
  for (Split& split : s.splits) {
    split.ambient.reset();
    split.primary.reset();
  }
  s.level.reset();
  s.band_gain.reset();
  s.limiter.reset();
  std::ranges::fill(s.out, 0.0F);
  s.filled = 0;
  s.level_gain = 1.0F;
  s.high_gains = s.next_high_gains = {1.0F, 1.0F};
  s.has_heard = false;
}

}  // namespace earpoint
