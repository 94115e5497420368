#include <earpoint/render/source_stream.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/window_of.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kBlock = 16384;
constexpr double kShortest_s = 0.1;
constexpr int kLowestRate_hz = 16000;
constexpr double kSilence_db = -100.0;
// The order-5 band-pass's edge at 80 Hz decays by 120 dB in 90 ms. (Its other edge, one hertz below
// Nyquist, rings for seconds, but no recording has any sound in that last hertz.)
constexpr double kFilterMargin_s = 0.25;

void check_finite(const Waveform& block, const std::string& where, double time_s) {
  for (int ear = 0; ear < 2; ++ear) {
    const auto samples = block.channel(ear);
    const auto bad = std::find_if_not(samples.begin(), samples.end(),
                                      [](float sample) { return std::isfinite(sample); });
    if (bad == samples.end()) continue;
    const double at_s =
        time_s + static_cast<double>(bad - samples.begin()) / block.sample_rate_hz();
    throw InputError(where, fmt::format("the sound has a NaN or infinite sample at {:.3f} s", at_s),
                     "write the file again");
  }
}

}  // namespace

std::string warning_of(StereoKind kind) {
  constexpr const char* kEnd = "it is not binaural, and its directions are not those of the room";
  switch (kind) {
    case StereoKind::plausible:
      return {};
    case StereoKind::one_channel:
      return fmt::format("only one channel has sound: {}", kEnd);
    case StereoKind::same:
      return "both channels are the same, as of mono sound, which has no direction, or of dry "
             "sound "
             "straight ahead";
    case StereoKind::panned:
      return fmt::format("its channels differ in level and not in time, as panned sound does: {}",
                         kEnd);
    case StereoKind::inverted:
      return fmt::format("one channel has the opposite sign: {}", kEnd);
  }
  EARPOINT_CHECK(false);
}

SoundSurvey survey_blocks(const BlockReader& read, int sample_rate_hz, const std::string& where) {
  SoundSurvey survey;
  survey.sample_rate_hz = sample_rate_hz;
  if (survey.sample_rate_hz < kLowestRate_hz) {
    throw InputError(where,
                     fmt::format("has a sample rate of {} Hz, expected at least {} Hz",
                                 survey.sample_rate_hz, kLowestRate_hz),
                     "record at 48000 Hz; resampling cannot restore the missing band");
  }

  std::array<double, 2> energy{};
  StereoCheck stereo(survey.sample_rate_hz);
  for (Waveform block = read(kBlock); block.samples() > 0; block = read(kBlock)) {
    check_finite(block, where, survey.duration_s());
    stereo.add(block);
    for (int ear = 0; ear < 2; ++ear) {
      for (const float sample : std::as_const(block).channel(ear)) {
        energy[ear] += static_cast<double>(sample) * sample;
      }
    }
    survey.samples += block.samples();
  }
  if (survey.duration_s() < kShortest_s) {
    throw InputError(where, fmt::format("lasts {:.3f} s, at least {} s are needed",
                                        survey.duration_s(), kShortest_s));
  }
  for (int ear = 0; ear < 2; ++ear) {
    survey.level_db[ear] =
        10.0 * std::log10(energy[ear] / static_cast<double>(survey.samples) + 1e-30);
  }
  if (std::max(survey.level_db[0], survey.level_db[1]) < kSilence_db) {
    throw InputError(where, "is silent from end to end",
                     "check the recording's level and channels");
  }
  survey.stereo = stereo.kind();
  return survey;
}

BlockReader read_blocks(const Waveform& sound) {
  return [&sound, read = std::ptrdiff_t{0}](std::ptrdiff_t samples) mutable {
    const std::ptrdiff_t count = std::min(samples, sound.samples() - read);
    const std::ptrdiff_t start = std::exchange(read, read + count);
    return window_of(sound, start, count);
  };
}

SourceStream::SourceStream(BlockReader read, const SoundSurvey& survey, int model_rate_hz,
                           const AmbientOptions& ambient)
    : survey_(survey),
      read_(std::move(read)),
      model_samples_(std::llround(static_cast<double>(survey.samples) * model_rate_hz /
                                  survey.sample_rate_hz)),
      model_(2, model_rate_hz),
      primary_(2, model_rate_hz),
      native_(2, survey.sample_rate_hz),
      high_(2, survey.sample_rate_hz),
      outline_(survey.sample_rate_hz) {
  EARPOINT_CHECK(model_rate_hz <= survey.sample_rate_hz);
  if (model_rate_hz != survey.sample_rate_hz) {
    down_ = std::make_unique<StreamResampler>(2, survey.sample_rate_hz, model_rate_hz);
    up_ = std::make_unique<StreamResampler>(2, model_rate_hz, survey.sample_rate_hz);
  }
  if (ambient.separation != AmbientSeparation::bandpass) {
    suppressor_.emplace(ambient.separation, 2, model_rate_hz, ambient.cutoff_hz);
  } else if (ambient.cutoff_hz > 0.0) {
    primary_band_ =
        butterworth_bandpass(ambient.cutoff_hz, model_rate_hz / 2.0 - 1.0, model_rate_hz);
    filter_margin_ = std::lround(kFilterMargin_s * model_rate_hz);
  }
}

void SourceStream::append(const Waveform& block) {
  model_.append(block);
  if (suppressor_) primary_.append(suppressor_->process(block, ended_));
}

void SourceStream::read_block() {
  const Waveform block = read_(kBlock);
  ended_ = block.samples() == 0;
  if (!ended_) outline_.add(block);
  if (!down_) {
    append(block);
    return;
  }
  const Waveform low = down_->process(block, ended_);
  append(low);
  native_.append(block);
  const Waveform restored = up_->process(low, ended_);
  // Resampled there and back, the sound may be a sample longer than the recording, by rounding.
  const std::ptrdiff_t count = std::min(restored.samples(), native_.end() - high_.end());
  if (count <= 0) return;
  Waveform high = native_.copy(high_.end(), count);
  for (int ear = 0; ear < 2; ++ear) {
    std::transform(high.channel(ear).begin(), high.channel(ear).end(),
                   restored.channel(ear).begin(), high.channel(ear).begin(), std::minus<>());
  }
  high_.append(high);
  native_.drop_before(high_.end());
}

void SourceStream::separate_by_band(Window& window, std::ptrdiff_t start,
                                    std::ptrdiff_t context) const {
  // Only the recording itself is filtered, without silence added before or after it.
  const std::ptrdiff_t samples = window.ambient.samples();
  const std::ptrdiff_t first = start - context;
  const std::ptrdiff_t last = start + samples + context;
  const std::ptrdiff_t from = std::clamp(first - filter_margin_, std::ptrdiff_t{0}, model_.end());
  const std::ptrdiff_t to = std::clamp(last + filter_margin_, from, model_.end());
  const Waveform recorded = model_.copy(from, to - from);
  std::vector<double> filtered(static_cast<std::size_t>(to - from));
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<double> input(recorded.channel(ear).begin(), recorded.channel(ear).end());
    filter_zero_phase(primary_band_, input, filtered);
    for (std::ptrdiff_t i = std::max(first, from); i < std::min(last, to); ++i) {
      const auto kept = static_cast<float>(filtered[i - from]);
      if (i >= start && i < start + samples) {
        window.ambient.channel(ear)[i - start] = recorded.channel(ear)[i - from] - kept;
      }
      window.primary.channel(ear)[i - first] = kept;
    }
  }
}

void SourceStream::separate_by_noise(Window& window, std::ptrdiff_t start,
                                     std::ptrdiff_t context) const {
  const Waveform recorded =
      std::exchange(window.primary, primary_.copy(start - context, window.primary.samples()));
  for (int ear = 0; ear < 2; ++ear) {
    const auto ambient = window.ambient.channel(ear);
    for (std::ptrdiff_t i = 0; i < window.ambient.samples(); ++i) {
      ambient[i] = recorded.channel(ear)[context + i] - window.primary.channel(ear)[context + i];
    }
  }
}

SourceStream::Window SourceStream::window(std::ptrdiff_t start, std::ptrdiff_t samples,
                                          std::ptrdiff_t context) {
  const std::ptrdiff_t first = start - context;
  const std::ptrdiff_t last = start + samples + context;
  const StreamBuffer& latest = suppressor_ ? primary_ : model_;
  while (!ended_ && latest.end() < last + filter_margin_) read_block();

  Waveform recorded = model_.copy(first, last - first);
  const int rate = recorded.sample_rate_hz();
  Window window{std::move(recorded), Waveform(2, samples, rate)};
  if (suppressor_) separate_by_noise(window, start, context);
  if (!primary_band_.empty()) separate_by_band(window, start, context);
  model_.drop_before(first - filter_margin_);
  primary_.drop_before(first);
  return window;
}

Waveform SourceStream::high_band(std::ptrdiff_t start, std::ptrdiff_t count) {
  while (!ended_ && high_.end() < start + count) read_block();
  return high_.copy(start, count);
}

}  // namespace earpoint
