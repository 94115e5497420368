#include <earpoint/audio/loudness.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <earpoint/audio/butterworth.h>
#include <earpoint/audio/resample.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 48000;
constexpr std::ptrdiff_t kBlock = 19200;  // 400 ms
constexpr std::ptrdiff_t kHop = 4800;
constexpr double kAbsoluteGateLkfs = -70.0;
constexpr double kRelativeGateLu = -10.0;

// BS.1770-4, tables 1 and 2: a shelf for the head, and a high-pass.
constexpr std::array<SecondOrderSection, 2> kWeighting{{
    {.b0 = 1.53512485958697,
     .b1 = -2.69169618940638,
     .b2 = 1.19839281085285,
     .a1 = -1.69065929318241,
     .a2 = 0.73248077421585},
    {.b0 = 1.0, .b1 = -2.0, .b2 = 1.0, .a1 = -1.99004745483398, .a2 = 0.99007225036621},
}};

double lkfs_of(double power) { return -0.691 + 10.0 * std::log10(power); }

/// Mean squares of the weighted sound, summed over the channels, by block.
std::vector<double> block_powers(const Waveform& sound) {
  std::vector<double> squares(static_cast<std::size_t>(sound.samples()), 0.0);
  for (int c = 0; c < sound.channels(); ++c) {
    SectionFilter filter(kWeighting);
    for (std::size_t i = 0; i < squares.size(); ++i) {
      const double weighted = filter.process(sound.channel(c)[i]);
      squares[i] += weighted * weighted;
    }
  }
  std::vector<double> powers;
  const std::ptrdiff_t block = std::min(kBlock, sound.samples());
  for (std::ptrdiff_t start = 0; start + block <= sound.samples(); start += kHop) {
    double sum = 0.0;
    for (std::ptrdiff_t i = start; i < start + block; ++i) sum += squares[i];
    powers.push_back(sum / static_cast<double>(block));
  }
  return powers;
}

/// @return the mean of the powers above the gate; 0 if none is
double gated_mean(const std::vector<double>& powers, double gate_lkfs) {
  double sum = 0.0;
  int count = 0;
  for (const double power : powers) {
    if (power <= 0.0 || lkfs_of(power) <= gate_lkfs) continue;
    sum += power;
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

}  // namespace

std::optional<double> loudness_lkfs(const Waveform& sound) {
  EARPOINT_CHECK(!sound.empty());
  const std::vector<double> powers = block_powers(resample(sound, kRate_hz));
  const double audible = gated_mean(powers, kAbsoluteGateLkfs);
  if (audible == 0.0) return std::nullopt;
  const double gate = std::max(kAbsoluteGateLkfs, lkfs_of(audible) + kRelativeGateLu);
  return lkfs_of(gated_mean(powers, gate));
}

}  // namespace earpoint
