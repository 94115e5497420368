#include <earpoint/trace/response_end.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDecayed_db = -60.0;

// Energy by window and band.
using Windows = std::vector<BandArray>;

Windows window_energies(const PointResponse& response, double duration_s) {
  constexpr double kWindow_s = 0.05;
  const int count = std::max(4, static_cast<int>(duration_s / kWindow_s));
  Windows windows(count, BandArray{});
  const auto add = [&](double time_s, const BandArray& energy) {
    const int window = static_cast<int>(time_s / duration_s * count);
    if (window >= count) return;
    for (int band = 0; band < kOctaveBands; ++band) windows[window][band] += energy[band];
  };
  for (int bin = 0; bin < response.late.bins(); ++bin) {
    add((bin + 0.5) * response.late.bin_s(), response.late.bin_energy(bin));
  }
  for (const Arrival& arrival : response.arrivals) {
    BandArray energy;
    for (int band = 0; band < kOctaveBands; ++band) {
      energy[band] = arrival.gain[band] * arrival.gain[band];
    }
    add(arrival.delay_s, energy);
  }
  return windows;
}

double level_db(double energy) { return energy > 0.0 ? 10.0 * std::log10(energy) : -kInfinity; }

// Decay of a band in the second half, in dB per window, by least squares.
double fall_db(const Windows& windows, int band) {
  double n = 0.0;
  double sum_x = 0.0;
  double sum_y = 0.0;
  double sum_xx = 0.0;
  double sum_xy = 0.0;
  for (std::size_t i = windows.size() / 2; i < windows.size(); ++i) {
    const double y = level_db(static_cast<double>(windows[i][band]));
    if (!std::isfinite(y)) continue;
    const auto x = static_cast<double>(i);
    n += 1.0;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const double denominator = n * sum_xx - sum_x * sum_x;
  return denominator > 0.0 ? -(n * sum_xy - sum_x * sum_y) / denominator : 0.0;
}

}  // namespace

ResponseEnd response_end(const PointResponse& response, double duration_s) {
  EARPOINT_CHECK(duration_s > 0.0);
  const Windows windows = window_energies(response, duration_s);
  ResponseEnd end{.level_db = -kInfinity, .needed_s = duration_s};
  for (int band = 0; band < kOctaveBands; ++band) {
    double loudest = 0.0;
    for (const BandArray& window : windows) {
      loudest = std::max(loudest, static_cast<double>(window[band]));
    }
    const double last = static_cast<double>(windows.back()[band]);
    if (loudest <= 0.0 || last <= 0.0) continue;
    const double level = level_db(last / loudest);
    end.level_db = std::max(end.level_db, level);
    if (level <= kDecayed_db) continue;
    const double fall = fall_db(windows, band);
    const double window_s = duration_s / static_cast<double>(windows.size());
    const double needed_s =
        fall > 0.0 ? duration_s + (level - kDecayed_db) / fall * window_s : kInfinity;
    end.needed_s = std::max(end.needed_s, needed_s);
  }
  return end;
}

}  // namespace earpoint
