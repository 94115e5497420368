#include <earpoint/generate/stage_clock.h>

#include <ctime>

namespace earpoint {
namespace {

double thread_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

std::string_view name_of(Stage stage) {
  constexpr std::array<std::string_view, kStages> kNames = {
      "scene", "plan", "acoustics", "trace", "responses", "light", "pictures", "speech", "writing"};
  return kNames[static_cast<std::size_t>(stage)];
}

StageClock::StageClock() : last_s_(thread_seconds()) {}

void StageClock::charge(Stage stage) {
  const double now_s = thread_seconds();
  seconds_[static_cast<std::size_t>(stage)] += now_s - last_s_;
  last_s_ = now_s;
}

void StageClock::add(const StageClock& other) {
  for (std::size_t i = 0; i < seconds_.size(); ++i) seconds_[i] += other.seconds_[i];
}

}  // namespace earpoint
