#include "wave_solver.h"

#include "measurement.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <earpoint/pose.h>

namespace earpoint::gates {
namespace {

constexpr double kMargin_m = 0.4;  // between the places of interest and the absorbing layers
constexpr double kLayer_m = 1.2;   // thickness of the absorbing layers
constexpr double kDuration_s = 0.07;

// Courant's limit in the plane is sqrt(1/2).
constexpr double kCourant = 0.7;

// A pulse with its energy around 280 Hz.
double pulse(double time_s) {
  constexpr double kWidth_s = 0.7e-3;
  const double x = (time_s - 5.0 * kWidth_s) / kWidth_s;
  return x * std::exp(-0.5 * x * x);
}

class Grid {
 public:
  Grid(const PlanePoint& source, std::span<const PlanePoint> listeners, double step_m,
       double speed_m_per_s)
      : step_m_(step_m), time_step_s_(kCourant * step_m / speed_m_per_s) {
    PlanePoint low = source;
    PlanePoint high = source;
    for (const PlanePoint& point : listeners) {
      low = {std::min(low.x, point.x), std::min(low.y, point.y)};
      high = {std::max(high.x, point.x), std::max(high.y, point.y)};
    }
    constexpr double kBeyond_m = kMargin_m + kLayer_m;
    // The sides of blocks coincide with sides of cells.
    first_x_ = static_cast<int>(std::floor((low.x - kBeyond_m) / step_m));
    first_y_ = static_cast<int>(std::floor((low.y - kBeyond_m) / step_m));
    width_ = static_cast<int>(std::ceil((high.x + kBeyond_m) / step_m)) - first_x_;
    height_ = static_cast<int>(std::ceil((high.y + kBeyond_m) / step_m)) - first_y_;
    const std::size_t cells = static_cast<std::size_t>(width_) * height_;
    pressure_.assign(cells, 0.0F);
    pressure_x_.assign(cells, 0.0F);
    towards_x_.assign(cells, 0.0F);
    towards_y_.assign(cells, 0.0F);
    open_x_.assign(cells, 1.0F);
    open_y_.assign(cells, 1.0F);
    for (int i = 0; i < width_; ++i) keep_x_.push_back(keep(i, width_, speed_m_per_s));
    for (int i = 0; i < height_; ++i) keep_y_.push_back(keep(i, height_, speed_m_per_s));
  }

  void add(const PlaneBlock& block) {
    const auto cell = [&](double place_m, int first, int count) {
      const double index = std::clamp(place_m / step_m_ - first, -1.0, count + 1.0);
      return static_cast<int>(std::lround(index));
    };
    const int low_x = cell(block.low.x, first_x_, width_);
    const int high_x = cell(block.high.x, first_x_, width_);
    const int low_y = cell(block.low.y, first_y_, height_);
    const int high_y = cell(block.high.y, first_y_, height_);
    // Velocity (x, y) stands on the low side of cell (x, y).
    for (int y = std::max(0, low_y); y < std::min(height_, high_y + 1); ++y) {
      for (int x = std::max(0, low_x); x < std::min(width_, high_x + 1); ++x) {
        if (y < high_y) open_x_[at(x, y)] = 0.0F;
        if (x < high_x) open_y_[at(x, y)] = 0.0F;
      }
    }
  }

  // @return [listener][time]
  std::vector<std::vector<double>> run(const PlanePoint& source,
                                       std::span<const PlanePoint> listeners) {
    const int steps = static_cast<int>(kDuration_s / time_step_s_);
    std::vector<std::vector<double>> heard(listeners.size());
    for (int i = 0; i < steps; ++i) {
      move();
      for (const auto& [cell, share] : around(source)) {
        pressure_[cell] += static_cast<float>(share * pulse(i * time_step_s_));
        pressure_x_[cell] += static_cast<float>(0.5 * share * pulse(i * time_step_s_));
      }
      for (std::size_t j = 0; j < listeners.size(); ++j) {
        double sum = 0.0;
        for (const auto& [cell, share] : around(listeners[j])) {
          sum += share * static_cast<double>(pressure_[cell]);
        }
        heard[j].push_back(sum);
      }
    }
    return heard;
  }

  [[nodiscard]] double time_step_s() const { return time_step_s_; }

 private:
  struct Share {
    std::size_t cell = 0;
    double share = 0.0;
  };

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * width_ + x;
  }

  // Factor by which a time step damps waves across the layer (Berenger, 1994); damping grows with
  // the square of the depth in the layer.
  [[nodiscard]] float keep(int cell, int count, double speed_m_per_s) const {
    const double depth = 1.0 - std::min(cell + 0.5, count - cell - 0.5) * step_m_ / kLayer_m;
    constexpr double kLoss = 9.0;  // nepers, there and back
    const double damping = 1.5 * kLoss * speed_m_per_s / kLayer_m;
    return static_cast<float>(
        std::exp(-damping * std::pow(std::max(0.0, depth), 2) * time_step_s_));
  }

  // The four cells around a point, linearly weighted.
  [[nodiscard]] std::array<Share, 4> around(const PlanePoint& point) const {
    const double x = point.x / step_m_ - first_x_ - 0.5;
    const double y = point.y / step_m_ - first_y_ - 0.5;
    const int left = static_cast<int>(std::floor(x));
    const int low = static_cast<int>(std::floor(y));
    std::array<Share, 4> shares;
    for (int i = 0; i < 4; ++i) {
      const int right = i % 2;
      const int up = i / 2;
      shares[i] = {at(left + right, low + up),
                   std::abs(1 - right - (x - left)) * std::abs(1 - up - (y - low))};
    }
    return shares;
  }

  void move() {
    const auto courant = static_cast<float>(kCourant);
    for (int y = 1; y < height_; ++y) {
      const std::size_t row = at(0, y);
      for (int x = 1; x < width_; ++x) {
        const std::size_t i = row + x;
        towards_x_[i] =
            open_x_[i] * keep_x_[x] * (towards_x_[i] - courant * (pressure_[i] - pressure_[i - 1]));
        towards_y_[i] = open_y_[i] * keep_y_[y] *
                        (towards_y_[i] - courant * (pressure_[i] - pressure_[i - width_]));
      }
    }
    for (int y = 0; y + 1 < height_; ++y) {
      const std::size_t row = at(0, y);
      for (int x = 0; x + 1 < width_; ++x) {
        const std::size_t i = row + x;
        const float pressure_y = pressure_[i] - pressure_x_[i];
        pressure_x_[i] =
            keep_x_[x] * (pressure_x_[i] - courant * (towards_x_[i + 1] - towards_x_[i]));
        pressure_[i] =
            pressure_x_[i] +
            keep_y_[y] * (pressure_y - courant * (towards_y_[i + width_] - towards_y_[i]));
      }
    }
  }

  double step_m_;
  double time_step_s_;
  int first_x_ = 0;
  int first_y_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<float> pressure_;
  std::vector<float> pressure_x_;  // the part from waves along x
  std::vector<float> towards_x_;   // velocities, in units of pressure
  std::vector<float> towards_y_;
  std::vector<float> open_x_;  // 0 in and on blocks
  std::vector<float> open_y_;
  std::vector<float> keep_x_;
  std::vector<float> keep_y_;
};

// A time signal's spectrum at a complex wave number, for waves e^(-i k x) that decay.
std::complex<double> spectrum_at(const std::vector<double>& signal, double time_step_s,
                                 std::complex<double> wave_number, double speed_m_per_s) {
  const std::complex<double> step =
      std::exp(std::complex<double>(0.0, -speed_m_per_s * time_step_s) * wave_number);
  std::complex<double> turn = 1.0;
  std::complex<double> sum = 0.0;
  for (const double sample : signal) {
    sum += sample * turn;
    turn *= step;
  }
  return sum;
}

// The sound of a point source in a scene that is endless along z, from that of a line source: an
// integral over the wave number along z, with the rest of the wave number in the plane (Duhamel, J.
// Sound Vib. 197, 1996). The contour is one on which waves decay; 24 points are exact to 1e-6 in
// free field.
double point_source_energy(const std::vector<double>& line_source,
                           const std::vector<double>& pulses, double time_step_s,
                           double frequency_hz, double speed_m_per_s) {
  constexpr int kPoints = 24;
  constexpr double kEnd = 1.6;
  constexpr std::complex<double> kTurn{1.0, 1.0};
  std::complex<double> sum = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const std::complex<double> wave_number =
        2.0 * kPi * frequency_hz / speed_m_per_s * std::cos((i + 0.5) / kPoints * kEnd * kTurn);
    sum += wave_number * spectrum_at(line_source, time_step_s, wave_number, speed_m_per_s) /
           spectrum_at(pulses, time_step_s, wave_number, speed_m_per_s);
  }
  return std::norm(sum);
}

}  // namespace

std::vector<SolvedLevels> solve_waves(std::span<const PlaneBlock> blocks, const PlanePoint& source,
                                      std::span<const PlanePoint> listeners, double step_m,
                                      double speed_m_per_s) {
  Grid free(source, listeners, step_m, speed_m_per_s);
  Grid blocked = free;
  for (const PlaneBlock& block : blocks) blocked.add(block);
  const auto without = free.run(source, listeners);
  const auto with = blocked.run(source, listeners);
  std::vector<double> pulses;
  for (std::size_t i = 0; i < without[0].size(); ++i) {
    pulses.push_back(pulse(static_cast<double>(i) * free.time_step_s()));
  }
  const auto energy_of = [&](const std::vector<double>& line_source, double frequency_hz) {
    return point_source_energy(line_source, pulses, free.time_step_s(), frequency_hz,
                               speed_m_per_s);
  };
  std::vector<SolvedLevels> levels(listeners.size());
  for (std::size_t i = 0; i < listeners.size(); ++i) {
    for (std::size_t octave = 0; octave < kSolvedOctavesHz.size(); ++octave) {
      constexpr int kFrequencies = 23;
      double sum = 0.0;
      double weights = 0.0;
      for (int j = 0; j < kFrequencies; ++j) {
        const double octaves_away = 1.5 * ((j + 0.5) / kFrequencies - 0.5);
        const double frequency_hz = kSolvedOctavesHz[octave] * std::exp2(octaves_away);
        // White sound has its energy even over frequency, not over octaves.
        const double weight = frequency_hz * std::pow(band_weight(octaves_away, 0.5), 2);
        sum += weight * energy_of(with[i], frequency_hz) / energy_of(without[i], frequency_hz);
        weights += weight;
      }
      levels[i][octave] = decibels(sum / weights);
    }
  }
  return levels;
}

}  // namespace earpoint::gates
