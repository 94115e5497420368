#include "live_sound.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/render/render_stream.h>

namespace earpoint {
namespace {

constexpr double kWarmUp_s = 0.5;
constexpr double kPoseStep_s = 0.01;
// A stretch and its margins make one second, which is one window of most networks.
constexpr double kStretch_s = 0.6;
constexpr double kMargin_s = 0.2;
// Largest share of the time that may be spent on rendering stretches.
constexpr double kBusiest = 0.6;

Waveform cut(const Waveform& sound, std::ptrdiff_t start, std::ptrdiff_t samples) {
  Waveform part(2, samples, sound.sample_rate_hz());
  const std::ptrdiff_t first = std::clamp<std::ptrdiff_t>(start, 0, sound.samples());
  const std::ptrdiff_t end = std::clamp<std::ptrdiff_t>(start + samples, first, sound.samples());
  for (int ear = 0; ear < 2; ++ear) {
    std::copy(sound.channel(ear).begin() + first, sound.channel(ear).begin() + end,
              part.channel(ear).begin() + (first - start));
  }
  return part;
}

/// The recording as it is.
class RecordingSound : public LiveSound {
 public:
  explicit RecordingSound(const ServedClip& clip) : clip_(clip) {}
  Waveform part(std::ptrdiff_t start, std::ptrdiff_t samples, const Pose& /*pose*/) override {
    return recorded(clip_, start, samples);
  }

 private:
  const ServedClip& clip_;
};

/// gtf, hop by hop. A recording can be read ahead, so that no latency of the network remains.
class StreamSound : public LiveSound {
 public:
  StreamSound(const ServedClip& clip, const GtfWeights& weights)
      : clip_(clip),
        stream_(weights, {.sample_rate_hz = clip.sound.sample_rate_hz(),
                          .horizontal_fov_rad = clip.horizontal_fov_rad}) {
    stream_.see(clip.picture.get(), clip.speaker_box);
    stream_.place_speaker(clip.speaker_m);
  }

  Waveform part(std::ptrdiff_t start, std::ptrdiff_t samples, const Pose& pose) override {
    if (start != next_) leap(start, pose);
    next_ = start + samples;
    Waveform sound = recorded(clip_, start + stream_.latency_samples(), samples);
    const auto step = static_cast<std::ptrdiff_t>(kPoseStep_s * clip_.sound.sample_rate_hz());
    for (std::ptrdiff_t done = 0; done < samples; done += step) {
      const auto first = static_cast<std::size_t>(done);
      const auto count = static_cast<std::size_t>(std::min(step, samples - done));
      const auto end = static_cast<double>(first + count);
      stream_.move_to(interpolate(pose_, pose, end / static_cast<double>(samples)));
      const auto left = sound.channel(0).subspan(first, count);
      const auto right = sound.channel(1).subspan(first, count);
      stream_.process({left, right}, {left, right});
    }
    pose_ = pose;
    return sound;
  }

 private:
  void leap(std::ptrdiff_t start, const Pose& pose) {
    stream_.reset();
    stream_.move_to(pose);
    pose_ = pose;
    const std::ptrdiff_t latency = stream_.latency_samples();
    const auto warm_up = static_cast<std::ptrdiff_t>(kWarmUp_s * clip_.sound.sample_rate_hz());
    Waveform before = recorded(clip_, start - warm_up, warm_up + latency);
    stream_.process({before.channel(0), before.channel(1)}, {before.channel(0), before.channel(1)});
  }

  const ServedClip& clip_;
  RenderStream stream_;
  std::ptrdiff_t next_ = -1;
  Pose pose_;
};

/// All other methods, which render windows. A stretch is rendered ahead for the present pose; when
/// the earpoint moves, a stretch for the new pose replaces it, as often as the speed allows.
class StretchSound : public LiveSound {
 public:
  StretchSound(const ServedClip& clip, const std::string& model)
      : clip_(clip), synthesizer_(make_synthesizer(model, seen_with(clip.horizontal_fov_rad))) {}

  Waveform part(std::ptrdiff_t start, std::ptrdiff_t samples, const Pose& pose) override {
    const bool joins = start == next_ && covers(start, samples);
    next_ = start + samples;
    const bool ends = !covers(next_, samples);
    const bool moved = pose_ != pose && start >= may_render_;
    if (joins && !ends && !moved) return cut(stretch_, start - first_, samples);
    std::optional<Waveform> before;
    if (joins) before = cut(stretch_, start - first_, samples);
    render(start, samples, pose);
    Waveform now = cut(stretch_, 0, samples);
    return before ? crossfaded(*before, now) : now;
  }

 private:
  [[nodiscard]] bool covers(std::ptrdiff_t start, std::ptrdiff_t samples) const {
    return start >= first_ && start + samples <= first_ + stretch_.samples();
  }

  void render(std::ptrdiff_t start, std::ptrdiff_t samples, const Pose& pose) {
    const auto began = std::chrono::steady_clock::now();
    const double rate_hz = clip_.sound.sample_rate_hz();
    const auto margin = static_cast<std::ptrdiff_t>(kMargin_s * rate_hz);
    const auto length = std::max(static_cast<std::ptrdiff_t>(kStretch_s * rate_hz), 3 * samples);
    const SoundInMemory source =
        in_memory(clip_, recorded(clip_, start - margin, length + 2 * margin));
    stretch_ = cut(render_in_memory(source, *synthesizer_, EarpointPath(pose), {}), margin, length);
    first_ = start;
    pose_ = pose;
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    may_render_ = start + static_cast<std::ptrdiff_t>(took.count() / kBusiest * rate_hz);
  }

  const ServedClip& clip_;
  std::unique_ptr<AcousticSynthesizer> synthesizer_;
  Waveform stretch_{2, 0, 16000};
  std::ptrdiff_t first_ = 0;
  std::ptrdiff_t next_ = -1;
  std::ptrdiff_t may_render_ = 0;  // the first sample that may start another stretch
  Pose pose_;
};

class TruthSound : public LiveSound {
 public:
  explicit TruthSound(const ServedClip& clip) : clip_(clip) {
    EARPOINT_CHECK(!clip.places.empty());
  }

  Waveform part(std::ptrdiff_t start, std::ptrdiff_t samples, const Pose& pose) override {
    const auto nearest = std::ranges::min_element(clip_.places, {}, [&](const KnownPlace& place) {
      return norm(place.source_from_target.position_m - pose.position_m);
    });
    Waveform now = cut(nearest->sound, start, samples);
    const KnownPlace* before = start == next_ ? place_ : nullptr;
    place_ = &*nearest;
    next_ = start + samples;
    if (before == nullptr || before == place_) return now;
    return crossfaded(cut(before->sound, start, samples), now);
  }

 private:
  const ServedClip& clip_;
  const KnownPlace* place_ = nullptr;
  std::ptrdiff_t next_ = -1;
};

}  // namespace

SynthesizerOptions seen_with(double horizontal_fov_rad) {
  SynthesizerOptions options;
  options.horizontal_fov_rad = horizontal_fov_rad;
  return options;
}

SoundInMemory in_memory(const ServedClip& clip, Waveform sound) {
  SoundInMemory source;
  source.sound = std::move(sound);
  source.picture = clip.picture;
  source.speaker_box = clip.speaker_box;
  source.speaker_m = clip.speaker_m;
  return source;
}

Waveform recorded(const ServedClip& clip, std::ptrdiff_t start, std::ptrdiff_t samples) {
  return cut(clip.sound, start, samples);
}

Waveform crossfaded(const Waveform& before, const Waveform& after) {
  Waveform result = after;
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i < after.samples(); ++i) {
      const float share = static_cast<float>(i + 1) / static_cast<float>(after.samples());
      result.channel(ear)[i] = std::lerp(before.channel(ear)[i], after.channel(ear)[i], share);
    }
  }
  return result;
}

std::unique_ptr<LiveSound> make_live_sound(const ServedClip& clip, const ListenMethod& method) {
  if (method.model == "input") return std::make_unique<RecordingSound>(clip);
  if (method.gtf) return std::make_unique<StreamSound>(clip, *method.gtf);
  return std::make_unique<StretchSound>(clip, method.model);
}

std::unique_ptr<LiveSound> make_live_truth(const ServedClip& clip) {
  return std::make_unique<TruthSound>(clip);
}

}  // namespace earpoint
