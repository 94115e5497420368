#include <earpoint/audio/decay.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr const char* kWhere = "impulse response";

double decibels(double energy) { return 10.0 * std::log10(energy); }

/// A straight line through levels: level_db = start_db + slope_db * sample.
struct Line {
  double start_db = 0.0;
  double slope_db = 0.0;

  [[nodiscard]] double at(double sample) const { return start_db + slope_db * sample; }
  [[nodiscard]] double sample_at(double level_db) const { return (level_db - start_db) / slope_db; }
};

/// Sums for a least-squares line.
class LineFit {
 public:
  void add(double x, double y) {
    ++count_;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] Line line() const {
    const double slope = (count_ * xy_ - x_ * y_) / (count_ * xx_ - x_ * x_);
    return {(y_ - slope * x_) / count_, slope};
  }

 private:
  int count_ = 0;
  double x_ = 0.0;
  double y_ = 0.0;
  double xx_ = 0.0;
  double xy_ = 0.0;
};

/// Squared samples from the direct sound to the last one that is not zero.
std::vector<double> energies_from_direct_sound(std::span<const float> response) {
  float largest = 0.0F;
  for (std::size_t i = 0; i < response.size(); ++i) {
    if (!std::isfinite(response[i])) {
      throw InputError(kWhere, fmt::format("sample {} is not a finite number", i));
    }
    largest = std::max(largest, std::abs(response[i]));
  }
  if (largest == 0.0F) throw InputError(kWhere, "is silent");
  const auto first =
      std::ranges::find_if(response, [&](float x) { return std::abs(x) >= 0.1F * largest; });
  std::vector<double> energies;
  for (auto it = first; it != response.end(); ++it) energies.push_back(double{*it} * *it);
  while (energies.back() == 0.0) energies.pop_back();
  return energies;
}

double mean_energy(std::span<const double> energies) {
  double sum = 0.0;
  for (const double e : energies) sum += e;
  return sum / static_cast<double>(energies.size());
}

/// Line through the levels of blocks, from the first block below `from_db` to the first one below
/// `to_db`.
/// @return  false if fewer than two blocks lie there, or they do not fall
bool fit_levels(std::span<const double> energies, std::size_t block, double from_db, double to_db,
                Line& line) {
  LineFit fit;
  for (std::size_t start = 0; start + block <= energies.size(); start += block) {
    const double energy = mean_energy(energies.subspan(start, block));
    if (energy == 0.0) continue;  // a gap between early reflections
    const double level = decibels(energy);
    if (level <= to_db) break;
    if (fit.count() == 0 && level > from_db) continue;
    fit.add(static_cast<double>(start) + (static_cast<double>(block) - 1.0) / 2.0, level);
  }
  if (fit.count() < 2) return false;
  line = fit.line();
  return line.slope_db < 0.0;
}

/// Where a decay is cut, and the energy that it would have after the cut if there were no noise.
struct Cut {
  std::size_t samples = 0;
  double tail_energy = 0.0;
};

/// Lundeby's iteration: estimate the noise, fit the late decay above it, cut where they meet,
/// estimate the noise behind the cut, and so on.
Cut find_cut(std::span<const double> energies, double sample_rate_hz) {
  const std::size_t total = energies.size();
  const std::size_t last_tenth = total - std::max<std::size_t>(1, total / 10);
  double noise_db = decibels(mean_energy(energies.subspan(last_tenth)));
  Line line;
  // Blocks of 10 ms; shorter ones for a response of less than half a second.
  const double first_block = std::min(0.01 * sample_rate_hz, static_cast<double>(total) / 50.0);
  auto block = static_cast<std::size_t>(std::max(1.0, std::round(first_block)));
  if (total < 3) return {total, 0.0};
  if (!fit_levels(energies, block, HUGE_VAL, noise_db + 10.0, line)) {
    throw InputError(kWhere, "does not decay: its last tenth is not 10 dB below its beginning",
                     "is it an impulse response?");
  }

  double crossing = line.sample_at(noise_db);
  for (int round = 0; round < 10; ++round) {
    const double samples_per_10_db = -10.0 / line.slope_db;
    block = static_cast<std::size_t>(std::max(1.0, std::round(samples_per_10_db / 5.0)));
    const double behind = std::max(0.0, crossing + samples_per_10_db);
    const std::size_t noise_start =
        behind < static_cast<double>(last_tenth) ? static_cast<std::size_t>(behind) : last_tenth;
    noise_db = decibels(mean_energy(energies.subspan(noise_start)));
    // The late decay: 20 dB, beginning 8 dB above the noise.
    Line next;
    if (!fit_levels(energies, block, noise_db + 28.0, noise_db + 8.0, next)) break;
    line = next;
    const double moved = line.sample_at(noise_db) - crossing;
    crossing += moved;
    if (std::abs(moved) < 1.0) break;
  }
  const double cut = std::clamp(std::round(crossing), 1.0, static_cast<double>(total));
  const double tail =
      std::pow(10.0, line.at(cut) / 10.0) / (1.0 - std::pow(10.0, line.slope_db / 10.0));
  return {static_cast<std::size_t>(cut), tail};
}

/// Energies of the decay itself, up to the cut.
struct Decay {
  std::vector<double> energies;
  double tail_energy = 0.0;
};

Decay decay_of(std::span<const float> response, double sample_rate_hz) {
  EARPOINT_CHECK(sample_rate_hz > 0.0);
  Decay decay{energies_from_direct_sound(response), 0.0};
  const Cut cut = find_cut(decay.energies, sample_rate_hz);
  decay.energies.resize(cut.samples);
  decay.tail_energy = cut.tail_energy;
  return decay;
}

double decay_time_s(std::span<const float> response, double sample_rate_hz, const char* name,
                    double from_db, double to_db) {
  const std::vector<double> curve = energy_decay_db(response, sample_rate_hz);
  const auto first = std::ranges::find_if(curve, [&](double level) { return level <= from_db; });
  const auto last = std::find_if(first, curve.end(), [&](double level) { return level <= to_db; });
  if (last == curve.end()) {
    throw InputError(kWhere,
                     fmt::format("{} needs a decay to {:.0f} dB; it reaches {:.1f} dB before its "
                                 "noise or its end",
                                 name, to_db, curve.back()),
                     "use a longer recording or one with less noise");
  }
  if (first == last) {
    throw InputError(kWhere, fmt::format("falls from {:.0f} to {:.0f} dB within one sample, so {} "
                                         "has no value",
                                         from_db, to_db, name));
  }
  LineFit fit;
  for (auto it = first; it <= last; ++it) fit.add(static_cast<double>(it - first), *it);
  return -60.0 / fit.line().slope_db / sample_rate_hz;
}

}  // namespace

std::vector<double> energy_decay_db(std::span<const float> impulse_response,
                                    double sample_rate_hz) {
  const Decay decay = decay_of(impulse_response, sample_rate_hz);
  std::vector<double> curve(decay.energies.size());
  double sum = decay.tail_energy;
  for (std::size_t i = curve.size(); i-- > 0;) {
    sum += decay.energies[i];
    curve[i] = sum;
  }
  for (double& level : curve) level = decibels(level / sum);
  return curve;
}

double early_decay_time_s(std::span<const float> impulse_response, double sample_rate_hz) {
  return decay_time_s(impulse_response, sample_rate_hz, "EDT", 0.0, -10.0);
}

double reverberation_time_t20_s(std::span<const float> impulse_response, double sample_rate_hz) {
  return decay_time_s(impulse_response, sample_rate_hz, "T20", -5.0, -25.0);
}

double reverberation_time_t30_s(std::span<const float> impulse_response, double sample_rate_hz) {
  return decay_time_s(impulse_response, sample_rate_hz, "T30", -5.0, -35.0);
}

double clarity_c50_db(std::span<const float> impulse_response, double sample_rate_hz) {
  const Decay decay = decay_of(impulse_response, sample_rate_hz);
  const auto split = static_cast<std::size_t>(std::lround(0.05 * sample_rate_hz));
  double early = 0.0;
  double late = decay.tail_energy;
  for (std::size_t i = 0; i < decay.energies.size(); ++i) {
    (i < split ? early : late) += decay.energies[i];
  }
  if (late <= 0.0) throw InputError(kWhere, "nothing follows its first 50 ms: C50 has no value");
  return decibels(early / late);
}

}  // namespace earpoint
