#include <earpoint/dataset/pair_sample.h>

#include "byte_cache.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/fft.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/ears.h>
#include <earpoint/core/vector_clones.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRateHz = 16000;

using SharedSound = std::shared_ptr<const Waveform>;
using Response = SoundSpacesDataset::Response;
using Spectrum = std::vector<std::complex<float>>;

/// The transform of that size of this thread: transforms hold work space.
RealFft<float>& transform(int size) {
  thread_local std::map<int, RealFft<float>> transforms;
  return transforms.try_emplace(size, size).first->second;
}

/// Channel `channel` of the sound from `start`, which may be negative, zeros beyond its ends.
void copy_window(const Waveform& sound, int channel, std::ptrdiff_t start,
                 std::span<float> window) {
  std::ranges::fill(window, 0.0F);
  const std::ptrdiff_t first = std::max(start, std::ptrdiff_t{0});
  const std::ptrdiff_t last = std::min(start + std::ssize(window), sound.samples());
  if (first >= last) return;
  const auto samples = sound.channel(channel).subspan(first, last - first);
  std::ranges::copy(samples, window.begin() + (first - start));
}

/// The sound from sample `start` on.
Waveform after(const Waveform& sound, std::ptrdiff_t start) {
  if (start == 0) return sound;
  Waveform result(sound.channels(), sound.samples() - start, sound.sample_rate_hz());
  for (int c = 0; c < sound.channels(); ++c) copy_window(sound, c, start, result.channel(c));
  return result;
}

Waveform delayed(const Waveform& sound, std::ptrdiff_t samples) {
  Waveform result(sound.channels(), sound.samples() + samples, sound.sample_rate_hz());
  for (int c = 0; c < sound.channels(); ++c) copy_window(sound, c, -samples, result.channel(c));
  return result;
}

/// When a response begins: its first sample within 20 dB of the largest, in any ear.
std::ptrdiff_t arrival(const Waveform& response) {
  constexpr float kWithin = 0.1F;
  float largest = 0.0F;
  for (const float x : response.planar()) largest = std::max(largest, std::abs(x));
  std::ptrdiff_t first = response.samples();
  for (int ear = 0; ear < response.channels(); ++ear) {
    const auto samples = response.channel(ear);
    const auto found =
        std::ranges::find_if(samples, [&](float x) { return std::abs(x) >= kWithin * largest; });
    first = std::min(first, std::ptrdiff_t{found - samples.begin()});
  }
  return first;
}

/// The response from the mouth to a microphone close to it, with the delay of the source's
/// response.
Waveform near_microphone_response(const Waveform& to_source) {
  Waveform response(kEars, arrival(to_source) + 1, kRateHz);
  for (int ear = 0; ear < kEars; ++ear) response.channel(ear).back() = 1.0F;
  return response;
}

/// b *= a. Written out in floats: the product of std::complex checks for NaN, and compilers do not
/// vectorize it.
EARPOINT_VECTOR_CLONES_OF_PAIRS void multiply(const Spectrum& a, Spectrum& b) {
  const auto* __restrict from = reinterpret_cast<const float*>(a.data());
  auto* __restrict to = reinterpret_cast<float*>(b.data());
  const std::size_t size = 2 * b.size();
  for (std::size_t k = 0; k < size; k += 2) {
    const float re = from[k] * to[k] - from[k + 1] * to[k + 1];
    const float im = from[k] * to[k + 1] + from[k + 1] * to[k];
    to[k] = re;
    to[k + 1] = im;
  }
}

/// Convolution of `dry` with several responses, by one transform of `dry`. Gives the samples from
/// `lead` on, which circular wrap-around does not reach.
class WindowConvolver {
 public:
  WindowConvolver(const Waveform& dry, std::ptrdiff_t lead)
      : lead_(lead),
        samples_(dry.samples() - lead),
        fft_(transform(fast_fft_size(static_cast<int>(dry.samples())))),
        signal_(static_cast<std::size_t>(fft_.size())),
        dry_spectrum_(static_cast<std::size_t>(fft_.bins())),
        spectrum_(dry_spectrum_.size()) {
    copy_window(dry, 0, 0, signal_);
    fft_.forward(signal_, dry_spectrum_);
  }

  Waveform heard(const Waveform& response) {
    EARPOINT_CHECK(response.samples() <= lead_ + 1);
    Waveform sound(kEars, samples_, kRateHz);
    for (int ear = 0; ear < kEars; ++ear) {
      copy_window(response, ear, 0, signal_);
      fft_.forward(signal_, spectrum_);
      multiply(dry_spectrum_, spectrum_);
      fft_.inverse(spectrum_, signal_);
      std::copy_n(signal_.begin() + lead_, samples_, sound.channel(ear).begin());
    }
    return sound;
  }

 private:
  std::ptrdiff_t lead_;
  std::ptrdiff_t samples_;
  RealFft<float>& fft_;
  std::vector<float> signal_;
  Spectrum dry_spectrum_;
  Spectrum spectrum_;
};

/// The viewpoints and the speaker that a choice selects in a clip.
struct Chosen {
  const SoundSpacesViewpoint& source;
  const SoundSpacesViewpoint& target;
  const SoundSpacesSpeaker& speaker;
};

Chosen chosen(const SoundSpacesClip& clip, const SoundSpacesChoice& choice) {
  const Chosen found{clip.viewpoints.at(choice.source), clip.viewpoints.at(choice.target),
                     clip.speakers.at(choice.speaker)};
  EARPOINT_CHECK(choice.window_start >= 0);
  const int id = found.speaker.id;
  if (!found.speaker.speech || !found.source.rir.contains(id) || !found.target.rir.contains(id) ||
      !found.source.bboxes.contains(id)) {
    throw InputError(fmt::format("{}, clip {}", clip.scene, clip.index),
                     fmt::format("speaker {} has no speech, response or box", id));
  }
  return found;
}

Pose world_from_viewpoint(const SoundSpacesViewpoint& viewpoint) {
  return {from_soundspaces(viewpoint.location),
          quaternion_from_euler({.yaw_rad = viewpoint.rotation_rad})};
}

void check_rate(const fs::path& path) {
  const int rate_hz = probe_sound(path).sample_rate_hz;
  if (rate_hz >= kRateHz) return;
  throw InputError(path.string(),
                   fmt::format("expected {} Hz or more, found {} Hz", kRateHz, rate_hz));
}

std::size_t bytes_of(const Waveform& sound) { return sound.planar().size_bytes(); }

}  // namespace

struct PairSampler::State {
  State(const SoundSpacesDataset& data, std::size_t cache_bytes, ResponseDelays response_delays,
        PairTarget pair_target)
      : dataset(data), delays(response_delays), target(pair_target), cache(cache_bytes) {}

  SharedSound speech(const std::string& name) {
    return cache.get<Waveform>(
        "speech " + name,
        [&] {
          check_rate(dataset.speech_path(name));
          return dataset.read_speech(name);
        },
        bytes_of);
  }

  std::shared_ptr<const Response> response(const std::string& rir) {
    return cache.get<Response>(
        "response " + rir,
        [&] {
          check_rate(dataset.path_of(rir));
          return dataset.read_response(rir);
        },
        [](const Response& response) { return bytes_of(response.sound); });
  }

  std::shared_ptr<const Image> picture(const std::string& name) {
    return cache.get<Image>(
        "picture " + name, [&] { return read_image(dataset.path_of(name)); },
        [](const Image& image) { return image.pixels().size_bytes(); });
  }

  const SoundSpacesDataset& dataset;
  ResponseDelays delays;
  PairTarget target;
  ByteCache cache;
};

PairSampler::PairSampler(const SoundSpacesDataset& dataset, std::size_t cache_bytes,
                         ResponseDelays delays, PairTarget target)
    : state_(std::make_unique<State>(dataset, cache_bytes, delays, target)) {}
PairSampler::~PairSampler() = default;
PairSampler::PairSampler(PairSampler&&) noexcept = default;
PairSampler& PairSampler::operator=(PairSampler&&) noexcept = default;

PairTruth PairSampler::truth(const SoundSpacesClip& clip, const SoundSpacesChoice& choice,
                             std::ptrdiff_t samples) const {
  return truth(clip, choice, choice.window_start, samples);
}

PairTruth PairSampler::truth(const SoundSpacesClip& clip, const SoundSpacesChoice& choice,
                             std::ptrdiff_t start, std::ptrdiff_t samples) const {
  EARPOINT_CHECK(samples > 0);
  const auto [source, target, speaker] = chosen(clip, choice);
  PairTruth truth;
  const SharedSound speech = state_->speech(*speaker.speech);
  const auto to_source = state_->response(source.rir.at(speaker.id));
  if (state_->target == PairTarget::near_microphone) {
    truth.source_response = to_source->sound;
    truth.target_response = near_microphone_response(to_source->sound);
  } else {
    const auto to_target = state_->response(target.rir.at(speaker.id));
    const std::ptrdiff_t later =
        state_->delays == ResponseDelays::relative ? to_target->delay - to_source->delay : 0;
    truth.source_response = delayed(to_source->sound, std::max(-later, std::ptrdiff_t{0}));
    truth.target_response = delayed(to_target->sound, std::max(later, std::ptrdiff_t{0}));
  }
  truth.lead = std::max(truth.source_response.samples(), truth.target_response.samples()) - 1;
  truth.dry = Waveform(1, truth.lead + samples, kRateHz);
  copy_window(*speech, 0, start - truth.lead, truth.dry.channel(0));
  return truth;
}

PairSample PairSampler::sample(const SoundSpacesClip& clip, const SoundSpacesChoice& choice,
                               std::ptrdiff_t samples, std::ptrdiff_t context) const {
  EARPOINT_CHECK(context >= 0);
  const PairTruth truth =
      this->truth(clip, choice, choice.window_start - context, context + samples);
  const auto [source, target, speaker] = chosen(clip, choice);
  PairSample sample;
  WindowConvolver convolver(truth.dry, truth.lead);
  sample.source = convolver.heard(truth.source_response);
  sample.target = after(convolver.heard(truth.target_response), context);
  sample.dry = Waveform(1, samples, kRateHz);
  copy_window(truth.dry, 0, truth.lead + context, sample.dry.channel(0));
  sample.context = context;
  sample.picture = state_->picture(source.image);
  sample.speaker_box = from_soundspaces_box(source.bboxes.at(speaker.id));
  sample.world_from_source = world_from_viewpoint(source);
  const Pose source_from_world = inverse(sample.world_from_source);
  if (state_->target == PairTarget::viewpoint) {
    sample.source_from_target = source_from_world * world_from_viewpoint(target);
  }
  sample.speaker_m = transform_point(source_from_world, from_soundspaces(speaker.location));
  if (speaker.rotation_rad) {
    sample.speaker_yaw_rad = wrap_angle(*speaker.rotation_rad - source.rotation_rad);
  }
  return sample;
}

std::shared_ptr<const Image> PairSampler::picture(const SoundSpacesClip& clip,
                                                  int viewpoint) const {
  EARPOINT_CHECK(viewpoint >= 0 && viewpoint < std::ssize(clip.viewpoints));
  return state_->picture(clip.viewpoints[static_cast<std::size_t>(viewpoint)].image);
}

std::ptrdiff_t PairSampler::speech_samples(const SoundSpacesSpeaker& speaker) const {
  EARPOINT_CHECK(speaker.speech.has_value());
  return state_->speech(*speaker.speech)->samples();
}

namespace {

Waveform ears_swapped(const Waveform& sound) {
  Waveform result(kEars, sound.samples(), sound.sample_rate_hz());
  std::ranges::copy(sound.channel(0), result.channel(1).begin());
  std::ranges::copy(sound.channel(1), result.channel(0).begin());
  return result;
}

Image flipped(const Image& picture) {
  Image result(picture.width(), picture.height(), picture.channels());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      for (int c = 0; c < picture.channels(); ++c) {
        result.at(picture.width() - 1 - x, y, c) = picture.at(x, y, c);
      }
    }
  }
  return result;
}

Vector3 mirrored(const Vector3& v) { return {v.x, -v.y, v.z}; }

/// A turn about an axis becomes the opposite turn about the mirrored axis.
Pose mirrored(const Pose& pose) {
  const Quaternion& q = pose.orientation;
  return {mirrored(pose.position_m), {.w = q.w, .x = -q.x, .y = q.y, .z = -q.z}};
}

}  // namespace

PairSample without_context(PairSample sample) {
  sample.source = after(sample.source, sample.context);
  if (sample.ambient) sample.ambient = after(*sample.ambient, sample.context);
  if (sample.clean) sample.clean = after(*sample.clean, sample.context);
  sample.context = 0;
  return sample;
}

PairSample mirrored(const PairSample& sample) {
  PairSample result = sample;
  result.source = ears_swapped(sample.source);
  result.target = ears_swapped(sample.target);
  if (sample.ambient) result.ambient = ears_swapped(*sample.ambient);
  if (sample.clean) result.clean = ears_swapped(*sample.clean);
  result.picture = std::make_shared<const Image>(flipped(*sample.picture));
  if (sample.speaker_box) {
    result.speaker_box->x_min = 1.0 - sample.speaker_box->x_max;
    result.speaker_box->x_max = 1.0 - sample.speaker_box->x_min;
  }
  result.source_from_target = mirrored(sample.source_from_target);
  result.speaker_m = mirrored(sample.speaker_m);
  if (sample.speaker_yaw_rad) result.speaker_yaw_rad = wrap_angle(-*sample.speaker_yaw_rad);
  result.world_from_source = mirrored(sample.world_from_source);
  return result;
}

}  // namespace earpoint
