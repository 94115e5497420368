#include <earpoint/render/stream_rates.h>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kLowestRate_hz = 16000;
constexpr int kHighestRate_hz = 192000;
constexpr int kStep_hz = 50;

}  // namespace

void check_stream_rate(int sample_rate_hz) {
  if (sample_rate_hz >= kLowestRate_hz && sample_rate_hz <= kHighestRate_hz &&
      sample_rate_hz % kStep_hz == 0) {
    return;
  }
  throw InputError("sample rate", fmt::format("{} Hz is not supported", sample_rate_hz),
                   fmt::format("use a multiple of {} Hz from {} to {} Hz", kStep_hz, kLowestRate_hz,
                               kHighestRate_hz));
}

}  // namespace earpoint
