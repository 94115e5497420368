#include "stream_decoder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/media/media.h>

namespace earpoint {
namespace {

/// Timestamps are rounded, to a millisecond in some containers; only a larger step is a gap.
constexpr double kGapSeconds = 0.02;

template <typename T>
float sample_as_float(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<float>(value);
  } else if constexpr (std::is_unsigned_v<T>) {
    return (static_cast<float>(value) - 128.0F) / 128.0F;
  } else {
    return static_cast<float>(static_cast<double>(value) /
                              -static_cast<double>(std::numeric_limits<T>::min()));
  }
}

/// Appends one channel of a frame, planar or interleaved.
template <typename T>
void append_channel(const AVFrame& frame, int channel, std::int64_t begin, std::int64_t end,
                    std::vector<float>& out) {
  const bool is_planar = av_sample_fmt_is_planar(static_cast<AVSampleFormat>(frame.format)) != 0;
  const int stride = is_planar ? 1 : frame.ch_layout.nb_channels;
  const auto* samples = reinterpret_cast<const T*>(frame.extended_data[is_planar ? channel : 0]);
  if (!is_planar) samples += channel;
  for (std::int64_t i = begin; i < end; ++i) out.push_back(sample_as_float(samples[i * stride]));
}

/// @return false if the sample format is none of FFmpeg's known ones
bool append_samples(const AVFrame& frame, int channel, std::int64_t begin, std::int64_t end,
                    std::vector<float>& out) {
  switch (av_get_packed_sample_fmt(static_cast<AVSampleFormat>(frame.format))) {
    case AV_SAMPLE_FMT_U8:
      append_channel<std::uint8_t>(frame, channel, begin, end, out);
      return true;
    case AV_SAMPLE_FMT_S16:
      append_channel<std::int16_t>(frame, channel, begin, end, out);
      return true;
    case AV_SAMPLE_FMT_S32:
      append_channel<std::int32_t>(frame, channel, begin, end, out);
      return true;
    case AV_SAMPLE_FMT_S64:
      append_channel<std::int64_t>(frame, channel, begin, end, out);
      return true;
    case AV_SAMPLE_FMT_FLT:
      append_channel<float>(frame, channel, begin, end, out);
      return true;
    case AV_SAMPLE_FMT_DBL:
      append_channel<double>(frame, channel, begin, end, out);
      return true;
    default:
      return false;
  }
}

/// The preferred stream, or where that cannot be decoded, the first that can.
int decodable_stream(ffmpeg::InputContainer& container) {
  const auto has_decoder = [&](int index) {
    return avcodec_find_decoder(container.stream(index).codecpar->codec_id) != nullptr;
  };
  const int preferred = container.preferred_stream(StreamKind::audio);
  if (has_decoder(preferred)) return preferred;
  for (const StreamInfo& stream : container.describe().streams) {
    if (stream.kind != StreamKind::audio || !has_decoder(stream.index)) continue;
    container.warn(fmt::format("audio stream {} cannot be decoded (codec {}); took stream {} ({})",
                               preferred, container.describe(preferred).codec, stream.index,
                               stream.codec));
    return stream.index;
  }
  return preferred;  // the decoder says what is missing
}

int choose_stream(ffmpeg::InputContainer& container, const std::string& path,
                  std::optional<int> wanted) {
  if (!wanted) return decodable_stream(container);
  std::string known;
  for (const StreamInfo& stream : container.describe().streams) {
    if (stream.kind != StreamKind::audio) continue;
    if (stream.index == *wanted) return *wanted;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", stream.index);
  }
  if (known.empty()) throw InputError(path, "has no audio stream");
  throw InputError(path, fmt::format("stream {} is not an audio stream", *wanted),
                   fmt::format("choose an audio stream from {}", known));
}

std::array<int, 2> choose_channels(const std::string& where, const StreamInfo& info,
                                   const std::optional<std::array<int, 2>>& wanted) {
  if (wanted) {
    const int largest = std::max((*wanted)[0], (*wanted)[1]);
    const int smallest = std::min((*wanted)[0], (*wanted)[1]);
    if (smallest >= 0 && largest < info.channels) return *wanted;
    throw InputError(where,
                     fmt::format("has no channel {}; it has {}", smallest < 0 ? smallest : largest,
                                 info.channels),
                     fmt::format("choose the channel of each ear from 0 to {}", info.channels - 1));
  }
  if (info.channels == 2) return {0, 1};
  if (info.channels == 1) {
    throw InputError(where, "is mono; a binaural recording has two channels, left and right",
                     "name the channel of each ear, 0,0 to use the one channel for both");
  }
  throw InputError(where,
                   fmt::format("has {} channels ({}), not the two of a binaural recording",
                               info.channels, info.channel_layout),
                   "name the channel of each ear, left and right, e.g. 0,1");
}

}  // namespace

struct AudioReader::State {
  State(const std::filesystem::path& path, std::optional<std::array<int, 2>> binaural_channels,
        std::optional<int> audio_stream)
      : container(path),
        stream(choose_stream(container, path.string(), audio_stream)),
        info(container.describe(stream)),
        decoder(container, stream),
        frame(ffmpeg::make_frame()),
        following(ffmpeg::make_frame()) {
    channels = choose_channels(container.where(stream), info, binaural_channels);
    // The first frame tells the true rate: a header may state half of it (HE-AAC).
    has_following = decoder.next(*following);
    if (!has_following) {
      throw InputError(container.where(stream), "holds no sound", ffmpeg::kDamagedHint);
    }
    if (following->sample_rate > 0) info.sample_rate_hz = following->sample_rate;
    refill();
  }

  [[noreturn]] void throw_changed() const {
    throw InputError(
        container.where(stream, queued_s()),
        fmt::format("changes from {} channels at {} Hz to {} at {} Hz", info.channels,
                    info.sample_rate_hz, frame->ch_layout.nb_channels, frame->sample_rate),
        "convert it to one format first");
  }

  [[nodiscard]] double queued_s() const {
    return static_cast<double>(queued) / info.sample_rate_hz;
  }

  /// Decodes the next frame into `pending`, which must be used up. @return false at the end
  bool refill() {
    if (!has_following) return false;
    std::swap(frame, following);
    has_following = decoder.next(*following);
    queue_frame();
    return true;
  }

  /// Puts the decoded frame at its place in time.
  void queue_frame() {
    if (frame->sample_rate != info.sample_rate_hz ||
        frame->ch_layout.nb_channels != info.channels) {
      throw_changed();
    }
    std::int64_t overlap = 0;
    if (const auto start_s = frame_start_s()) {
      const double late_s = *start_s - queued_s();
      if (queued == 0 || std::abs(late_s) > kGapSeconds) {
        const auto late = std::llround(late_s * info.sample_rate_hz);
        overlap = std::clamp<std::int64_t>(-late, 0, frame->nb_samples);
        if (late > 0) owe_silence(late);
        warn_of_gap(late_s);
      }
    }
    const std::int64_t end = samples_meant();
    overlap = std::min(overlap, end);
    for (std::size_t ear = 0; ear < 2; ++ear) {
      pending[ear].clear();
      if (!append_samples(*frame, channels[ear], overlap, end, pending[ear])) {
        throw InputError(container.where(stream), "has samples of an unknown kind");
      }
    }
    taken = 0;
    queued += end - overlap;
  }

  /// Encoders pad their last frame; the frame's duration in the container tells how much counts.
  [[nodiscard]] std::int64_t samples_meant() const {
    const AVRational tick = container.stream(stream).time_base;
    const AVRational sample = {1, info.sample_rate_hz};
    if (has_following || frame->pkt_duration <= 0 || av_cmp_q(tick, sample) > 0) {
      return frame->nb_samples;
    }
    return std::min<std::int64_t>(frame->nb_samples,
                                  av_rescale_q(frame->pkt_duration, tick, sample));
  }

  [[nodiscard]] std::optional<double> frame_start_s() const {
    // The first Vorbis packet has a duration but gives no samples. FFmpeg dates the samples of the
    // second packet, the first that are heard, late by this duration.
    if (queued == 0 && info.codec == "vorbis") return info.start_s;
    return container.time_s(stream, frame->best_effort_timestamp);
  }

  void owe_silence(std::int64_t samples) {
    const std::optional<double> end_s = container.describe().duration_s;
    constexpr double kSlackSeconds = 1.0;
    const double until_s = queued_s() + static_cast<double>(samples) / info.sample_rate_hz;
    if (end_s && until_s > *end_s + kSlackSeconds) {
      throw InputError(container.where(stream, queued_s()),
                       fmt::format("the next timestamp is {:.3f} s, past the end", until_s),
                       ffmpeg::kDamagedHint);
    }
    silence_left = samples;
    queued += samples;
  }

  void warn_of_gap(double late_s) {
    constexpr double kWorthTelling_s = 1.0;
    // `queued` includes the silence already; silence before the first sample is no gap.
    const double from_s = queued_s() - late_s;
    if (late_s < kWorthTelling_s || from_s <= 0.0) return;
    container.warn(fmt::format("has no sound from {:.3f} to {:.3f} s; replaced by silence", from_s,
                               queued_s()));
  }

  ffmpeg::InputContainer container;
  int stream;
  StreamInfo info;
  ffmpeg::StreamDecoder decoder;
  ffmpeg::FramePtr frame;
  ffmpeg::FramePtr following;  // decoded ahead, to know which frame is the last
  bool has_following = false;
  std::array<int, 2> channels{};
  std::int64_t queued = 0;                    // samples since t = 0, silence and `pending` included
  std::int64_t silence_left = 0;              // still to be given out, before `pending`
  std::array<std::vector<float>, 2> pending;  // one decoded frame
  std::size_t taken = 0;                      // of pending
};

AudioReader::AudioReader(const std::filesystem::path& path,
                         std::optional<std::array<int, 2>> binaural_channels,
                         std::optional<int> audio_stream)
    : state_(std::make_unique<State>(path, binaural_channels, audio_stream)) {}
AudioReader::~AudioReader() = default;
AudioReader::AudioReader(AudioReader&&) noexcept = default;
AudioReader& AudioReader::operator=(AudioReader&&) noexcept = default;

int AudioReader::sample_rate_hz() const { return state_->info.sample_rate_hz; }
const StreamInfo& AudioReader::info() const { return state_->info; }
const std::vector<std::string>& AudioReader::warnings() const {
  return state_->container.warnings();
}

std::optional<double> AudioReader::duration_s() const {
  const StreamInfo& info = state_->info;
  if (info.duration_s) return info.start_s + *info.duration_s;
  return state_->container.describe().duration_s;
}

Waveform AudioReader::read(std::ptrdiff_t frames) {
  EARPOINT_CHECK(frames > 0);
  State& state = *state_;
  std::array<std::vector<float>, 2> block;
  const auto wanted = static_cast<std::size_t>(frames);
  while (block[0].size() < wanted) {
    const std::size_t missing = wanted - block[0].size();
    if (state.silence_left > 0) {
      const auto count = std::min(
          missing, static_cast<std::size_t>(std::min<std::int64_t>(state.silence_left, 1 << 16)));
      for (auto& ear : block) ear.insert(ear.end(), count, 0.0F);
      state.silence_left -= static_cast<std::int64_t>(count);
    } else if (state.taken < state.pending[0].size()) {
      const std::size_t count = std::min(missing, state.pending[0].size() - state.taken);
      for (std::size_t ear = 0; ear < 2; ++ear) {
        const auto from = state.pending[ear].begin() + static_cast<std::ptrdiff_t>(state.taken);
        block[ear].insert(block[ear].end(), from, from + static_cast<std::ptrdiff_t>(count));
      }
      state.taken += count;
    } else if (!state.refill()) {
      break;
    }
  }
  Waveform waveform(2, static_cast<std::ptrdiff_t>(block[0].size()), state.info.sample_rate_hz);
  std::copy(block[0].begin(), block[0].end(), waveform.channel(0).begin());
  std::copy(block[1].begin(), block[1].end(), waveform.channel(1).begin());
  return waveform;
}

}  // namespace earpoint
