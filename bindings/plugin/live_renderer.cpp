#include "live_renderer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <semaphore.h>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/renderer.h>
#include <earpoint/stream.h>

#include "stereo_delay.h"

namespace earpoint::plugin {
namespace {

/// A gtf network hears a second at a time, and a stream's level and summary follow the last second.
constexpr double kWarmUp_s = 1.0;
constexpr double kModelFade_s = 0.05;
constexpr double kBypassFade_s = 0.01;
/// No device is faster; what the library streams is less.
constexpr double kHighestRate_hz = 1e6;
/// What is processed at a time, so that buffers have a fixed size.
constexpr std::ptrdiff_t kChunk = 256;
constexpr std::size_t kChannels = 2;

using Chunk = std::array<std::array<float, kChunk>, kChannels>;

std::array<float*, kChannels> pointers(Chunk& chunk) { return {chunk[0].data(), chunk[1].data()}; }

/// A stream that plays or waits for its turn.
struct Slot {
  Slot(Stream&& stream_in, std::ptrdiff_t late)
      : stream(std::move(stream_in)), pad(late - stream.latency_samples()) {}

  void apply(const Settings& settings) {
    stream.move_to(settings.earpoint);
    stream.place_speaker(settings.speaker_m);
  }
  void process(const float* const* in, float* const* out, std::ptrdiff_t frames) {
    stream.process(in, out, frames);
    pad.process(out, out, frames);
  }
  void reset() {
    stream.reset();
    pad.reset();
  }

  Stream stream;
  StereoDelay pad;  ///< makes it as late as the slowest
  /// Silent and unheard: the audio thread may take it. Otherwise it plays, or waits to be reset.
  std::atomic<bool> fresh{true};
  std::atomic<bool> done{false};  ///< the audio thread has no more use for it
};

/// Wakes a thread from the audio thread, without a lock.
class Signal {
 public:
  Signal() { ::sem_init(&semaphore_, 0, 0); }
  ~Signal() { ::sem_destroy(&semaphore_); }
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;
  void send() { ::sem_post(&semaphore_); }
  void wait() {
    while (::sem_wait(&semaphore_) != 0) {
    }
  }

 private:
  ::sem_t semaphore_{};
};

/// The two streams of a model: by natural texture and by the mean. One for both if it has only one
/// texture.
struct Textures {
  Slot* natural = nullptr;
  Slot* mean = nullptr;
};

/// @return nothing if the network has one texture only
std::optional<Stream> stream_of_mean(const std::string& file, const StreamOptions& options) {
  try {
    return Renderer::open(file, {.texture = 0.0}).stream(options);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// @param left_out  gets a line if the file is no network any more
std::optional<Renderer> opened(const std::string& file, std::vector<std::string>& left_out) {
  try {
    return Renderer::open(file);
  } catch (const std::exception& error) {
    left_out.emplace_back(error.what());
    return std::nullopt;
  }
}

}  // namespace

struct LiveRenderer::State {
  State() : worker([this](const std::stop_token& stop) { reset_used(stop); }) {}
  ~State() {
    worker.request_stop();
    signal.send();
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void make_streams(const std::vector<StreamingModel>& files, double sample_rate_hz);
  void fail(Status why, const std::string& text);
  void reset_used(const std::stop_token& stop);
  [[nodiscard]] Slot* slot_of(const Settings& settings) const;
  void choose(const Settings& settings);
  void run_chunk(bool bypass, const float* const* in, float* const* out, std::ptrdiff_t frames);
  void fade_in_next(float* const* out, std::ptrdiff_t frames);
  void fade_bypass(bool bypass, float* const* out, std::ptrdiff_t frames);

  Status status = Status::renders;
  std::string problem;
  std::vector<std::string> left_out;
  std::vector<std::unique_ptr<Slot>> slots;
  std::vector<Textures> models;
  std::ptrdiff_t late = 0;
  std::ptrdiff_t warm_up = 0;  ///< samples, as the fades
  std::ptrdiff_t model_fade = 1;
  std::ptrdiff_t bypass_fade = 1;
  StereoDelay dry_delay{0};

  Slot* now = nullptr;              ///< what plays; null before the first block
  Slot* next = nullptr;             ///< what it is switched to; null: no switch
  std::ptrdiff_t next_heard = 0;    ///< samples that `next` has had
  std::ptrdiff_t bypass_place = 0;  ///< 0: rendered, bypass_fade: the input

  Chunk input{};
  Chunk other{};
  Chunk dry{};

  std::mutex resetting;  ///< between reset() and the worker; never of the audio thread
  Signal signal;
  std::jthread worker;  // last: it uses the others
};

void LiveRenderer::State::make_streams(const std::vector<StreamingModel>& files,
                                       double sample_rate_hz) {
  if (files.empty()) return fail(Status::no_model, "models: none is installed; see docs/plugin.md");
  const bool is_whole = sample_rate_hz == std::floor(sample_rate_hz);
  if (!is_whole || sample_rate_hz < 0.0 || sample_rate_hz > kHighestRate_hz) {
    return fail(Status::rate_not_supported,
                fmt::format("sample rate: {} Hz is not supported", sample_rate_hz));
  }
  const StreamOptions options{.sample_rate_hz = static_cast<int>(sample_rate_hz)};
  struct Made {
    Stream natural;
    std::optional<Stream> mean;
  };
  std::vector<std::optional<Made>> made;
  for (const StreamingModel& model : files) {
    const std::string file = model.file.string();
    const std::optional<Renderer> renderer = opened(file, left_out);
    auto& streams = made.emplace_back();
    if (!renderer) continue;
    try {
      streams = Made{renderer->stream(options), stream_of_mean(file, options)};
    } catch (const InputError& error) {
      return fail(Status::rate_not_supported, error.what());
    }
    late = std::max(late, streams->natural.latency_samples());
  }
  if (left_out.size() == files.size()) return fail(Status::no_model, left_out.front());
  const auto add = [this](Stream&& stream) {
    return slots.emplace_back(std::make_unique<Slot>(std::move(stream), late)).get();
  };
  for (std::optional<Made>& both : made) {
    models.emplace_back();
    if (!both) continue;
    Slot* const natural = add(std::move(both->natural));
    models.back() = {natural, both->mean ? add(std::move(*both->mean)) : natural};
  }
  const Textures first = *std::ranges::find_if(models, &Textures::natural);
  std::ranges::replace_if(
      models, [](const Textures& of) { return of.natural == nullptr; }, first);
  warm_up = std::lround(kWarmUp_s * sample_rate_hz);
  model_fade = std::lround(kModelFade_s * sample_rate_hz);
  bypass_fade = std::lround(kBypassFade_s * sample_rate_hz);
  dry_delay = StereoDelay(late);
}

void LiveRenderer::State::fail(Status why, const std::string& text) {
  status = why;
  problem = text;
  late = 0;
}

void LiveRenderer::State::reset_used(const std::stop_token& stop) {
  for (;;) {
    signal.wait();
    if (stop.stop_requested()) return;
    const std::scoped_lock lock(resetting);
    for (const auto& slot : slots) {
      if (!slot->done.exchange(false, std::memory_order_acquire)) continue;
      slot->reset();
      slot->fresh.store(true, std::memory_order_release);
    }
  }
}

Slot* LiveRenderer::State::slot_of(const Settings& settings) const {
  const bool known = settings.model >= 0 && settings.model < std::ssize(models);
  const Textures& model = models[known ? static_cast<std::size_t>(settings.model) : 0];
  return settings.natural_texture ? model.natural : model.mean;
}

void LiveRenderer::State::choose(const Settings& settings) {
  Slot* const wanted = slot_of(settings);
  const auto take = [](Slot* slot) {
    return slot->fresh.exchange(false, std::memory_order_acquire);
  };
  if (now == nullptr) {
    (void)take(wanted);  // all are fresh now
    now = wanted;
    bypass_place = settings.bypass ? bypass_fade : 0;
  } else if (next == nullptr && wanted != now && take(wanted)) {
    next = wanted;
    next_heard = 0;
  }
  now->apply(settings);
  if (next != nullptr) next->apply(settings);
}

void LiveRenderer::State::fade_in_next(float* const* out, std::ptrdiff_t frames) {
  const auto there = pointers(other);
  const std::array<const float*, kChannels> heard{input[0].data(), input[1].data()};
  next->process(heard.data(), there.data(), frames);
  for (std::size_t c = 0; c < kChannels; ++c) {
    for (std::ptrdiff_t i = 0; i < frames; ++i) {
      const std::ptrdiff_t place = next_heard + i + 1 - warm_up;
      const float part = static_cast<float>(std::clamp<std::ptrdiff_t>(place, 0, model_fade)) /
                         static_cast<float>(model_fade);
      out[c][i] = std::lerp(out[c][i], other[c][i], part);
    }
  }
  next_heard += frames;
  if (next_heard < warm_up + model_fade) return;
  now->done.store(true, std::memory_order_release);
  signal.send();
  now = std::exchange(next, nullptr);
}

void LiveRenderer::State::fade_bypass(bool bypass, float* const* out, std::ptrdiff_t frames) {
  const std::ptrdiff_t goal = bypass ? bypass_fade : 0;
  for (std::ptrdiff_t i = 0; i < frames; ++i) {
    if (bypass_place != goal) bypass_place += bypass ? 1 : -1;
    if (bypass_place == 0) continue;
    for (std::size_t c = 0; c < kChannels; ++c) {
      const float part = static_cast<float>(bypass_place) / static_cast<float>(bypass_fade);
      out[c][i] = bypass_place == bypass_fade ? dry[c][i] : std::lerp(out[c][i], dry[c][i], part);
    }
  }
}

void LiveRenderer::State::run_chunk(bool bypass, const float* const* in, float* const* out,
                                    std::ptrdiff_t frames) {
  for (std::size_t c = 0; c < kChannels; ++c) std::copy_n(in[c], frames, input[c].begin());
  const std::array<const float*, kChannels> heard{input[0].data(), input[1].data()};
  const auto delayed = pointers(dry);
  dry_delay.process(heard.data(), delayed.data(), frames);
  now->process(heard.data(), out, frames);
  if (next != nullptr) fade_in_next(out, frames);
  fade_bypass(bypass, out, frames);
}

LiveRenderer::LiveRenderer(const std::vector<StreamingModel>& models, double sample_rate_hz)
    : state_(std::make_unique<State>()) {
  state_->make_streams(models, sample_rate_hz);
}

LiveRenderer::~LiveRenderer() = default;

const std::string& LiveRenderer::problem() const { return state_->problem; }
Status LiveRenderer::status() const { return state_->status; }
const std::vector<std::string>& LiveRenderer::left_out() const { return state_->left_out; }

void LiveRenderer::reset() {
  State& s = *state_;
  const std::scoped_lock lock(s.resetting);
  for (const auto& slot : s.slots) {
    if (slot->fresh) continue;
    slot->done = false;
    slot->reset();
    slot->fresh = true;
  }
  s.dry_delay.reset();
  s.now = s.next = nullptr;
}

void LiveRenderer::process(const Settings& settings, const float* const* in, float* const* out,
                           std::ptrdiff_t frames) {
  State& s = *state_;
  if (!s.problem.empty()) {
    for (std::ptrdiff_t i = 0; i < frames; ++i) {
      const float left = in[0][i];  // the host's memory may be the same, with the ears swapped
      const float right = in[1][i];
      out[0][i] = left;
      out[1][i] = right;
    }
    return;
  }
  for (std::ptrdiff_t done = 0; done < frames; done += kChunk) {
    s.choose(settings);
    const std::array<const float*, kChannels> from{in[0] + done, in[1] + done};
    const std::array<float*, kChannels> to{out[0] + done, out[1] + done};
    s.run_chunk(settings.bypass, from.data(), to.data(), std::min(kChunk, frames - done));
  }
}

bool LiveRenderer::is_ready_for(const Settings& settings) const {
  if (!state_->problem.empty()) return false;
  const Slot* const wanted = state_->slot_of(settings);
  return wanted == state_->now || wanted->fresh;
}

std::ptrdiff_t LiveRenderer::latency_samples() const { return state_->late; }

std::optional<Vector3> LiveRenderer::speaker_m() const {
  return state_->now == nullptr ? std::nullopt : state_->now->stream.speaker_m();
}

}  // namespace earpoint::plugin
