#include <earpoint/stream.h>

#include "stream_state.h"

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <variant>

#include <earpoint/error.h>
#include <earpoint/synthesis/speaker_track.h>

namespace earpoint {

Stream::Stream(std::unique_ptr<State> state) : state_(std::move(state)) {}
Stream::~Stream() = default;
Stream::Stream(Stream&&) noexcept = default;
Stream& Stream::operator=(Stream&&) noexcept = default;

void Stream::see(const Image& picture, const std::optional<Box>& speaker_box) {
  EARPOINT_CHECK(!picture.empty() && picture.channels() == 3);
  std::optional<Box> box;
  if (speaker_box) {
    box = SpeakerTrack(*speaker_box, std::array{picture.width(), picture.height()}).at(0.0);
  }
  std::visit([&](auto& stream) { stream.see(&picture, box); }, state_->stream);
}

void Stream::see_nothing(const std::optional<Box>& speaker_box) {
  std::optional<Box> box;
  if (speaker_box) box = SpeakerTrack(*speaker_box).at(0.0);
  std::visit([&](auto& stream) { stream.see(nullptr, box); }, state_->stream);
}

void Stream::place_speaker(const std::optional<Vector3>& mouth_m) {
  std::visit([&](auto& stream) { stream.place_speaker(mouth_m); }, state_->stream);
}

void Stream::move_to(const Pose& source_from_target) {
  std::visit([&](auto& stream) { stream.move_to(source_from_target); }, state_->stream);
}

void Stream::process(const float* const* in, float* const* out, std::ptrdiff_t frames) {
  EARPOINT_CHECK(frames >= 0);
  const auto samples = static_cast<std::size_t>(frames);
  const std::array from{std::span(in[0], samples), std::span(in[1], samples)};
  const std::array to{std::span(out[0], samples), std::span(out[1], samples)};
  std::visit([&](auto& stream) { stream.process(from, to); }, state_->stream);
}

std::ptrdiff_t Stream::latency_samples() const {
  return std::visit([](const auto& stream) { return stream.latency_samples(); }, state_->stream);
}

std::optional<Vector3> Stream::speaker_m() const {
  return std::visit([](const auto& stream) { return stream.speaker_m(); }, state_->stream);
}

void Stream::reset() {
  std::visit([](auto& stream) { stream.reset(); }, state_->stream);
}

}  // namespace earpoint
