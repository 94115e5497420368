#include <earpoint/core/progress.h>

#include <algorithm>
#include <cmath>

#include <unistd.h>

namespace earpoint {
namespace {

constexpr int kBarWidth = 28;
constexpr std::chrono::milliseconds kTerminalInterval{100};
constexpr std::chrono::seconds kLineInterval{10};

}  // namespace

StreamProgress::StreamProgress(std::FILE* stream)
    : StreamProgress(stream, ::isatty(::fileno(stream)) == 1) {}

StreamProgress::StreamProgress(std::FILE* stream, bool is_terminal)
    : stream_(stream), is_terminal_(is_terminal) {}

void StreamProgress::begin(const std::string& label, double total, const std::string& unit) {
  const std::lock_guard lock(mutex_);
  label_ = label;
  unit_ = unit;
  total_ = total;
  done_ = 0.0;
  start_ = last_draw_ = std::chrono::steady_clock::now();
  if (is_terminal_) draw(false);
}

void StreamProgress::advance(double amount) {
  const std::lock_guard lock(mutex_);
  done_ += amount;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_draw_ < (is_terminal_ ? std::chrono::nanoseconds(kTerminalInterval)
                                       : std::chrono::nanoseconds(kLineInterval))) {
    return;
  }
  last_draw_ = now;
  draw(false);
}

void StreamProgress::finish() {
  const std::lock_guard lock(mutex_);
  draw(true);
}

void StreamProgress::note(const std::string& line) {
  const std::lock_guard lock(mutex_);
  // The next report draws the bar again.
  if (is_terminal_) std::fprintf(stream_, "\r\033[K");
  std::fprintf(stream_, "%s\n", line.c_str());
  std::fflush(stream_);
}

void StreamProgress::draw(bool last) {
  const double elapsed =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = elapsed > 0.0 ? done_ / elapsed : 0.0;
  const double fraction = total_ > 0.0 ? std::clamp(done_ / total_, 0.0, 1.0) : 0.0;

  if (is_terminal_) std::fprintf(stream_, "\r\033[K");
  std::fprintf(stream_, "%s ", label_.c_str());
  if (is_terminal_ && total_ > 0.0) {
    const int filled = static_cast<int>(std::lround(fraction * kBarWidth));
    for (int i = 0; i < kBarWidth; ++i) std::fputs(i < filled ? "█" : "░", stream_);
    std::fputc(' ', stream_);
  }
  if (total_ > 0.0) {
    std::fprintf(stream_, "%3.0f %%  %.4g/%.4g %s", 100.0 * fraction, done_, total_, unit_.c_str());
  } else {
    std::fprintf(stream_, "%.4g %s", done_, unit_.c_str());
  }
  std::fprintf(stream_, "  %.3g %s/s", rate, unit_.c_str());
  if (last) {
    std::fprintf(stream_, "  in %s\n", format_duration(elapsed).c_str());
  } else {
    if (rate > 0.0 && total_ > 0.0) {
      std::fprintf(stream_, "  %s left", format_duration((total_ - done_) / rate).c_str());
    }
    if (!is_terminal_) std::fputc('\n', stream_);
  }
  std::fflush(stream_);
}

std::string format_duration(double seconds) {
  const auto whole = static_cast<long long>(std::llround(std::max(0.0, seconds)));
  char text[64];
  if (whole < 60) {
    std::snprintf(text, sizeof(text), "%lld s", whole);
  } else if (whole < 3600) {
    std::snprintf(text, sizeof(text), "%lld min %02lld s", whole / 60, whole % 60);
  } else {
    std::snprintf(text, sizeof(text), "%lld h %02lld min", whole / 3600, whole / 60 % 60);
  }
  return text;
}

}  // namespace earpoint
