#include "gates.h"
#include "measurement.h"
#include "rooms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <limits>
#include <string_view>

#include <fmt/core.h>

#include <earpoint/audio/fft.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_synthesizer.h>

namespace earpoint::gates {
namespace {

constexpr int kRate_hz = 48000;

struct Direction {
  std::string_view name;
  Vector3 towards;
};
// On the median plane, where interaural differences vanish, and at the sides.
constexpr std::array<Direction, 6> kDirections = {{{"front", {1, 0, 0}},
                                                   {"back", {-1, 0, 0}},
                                                   {"front above", {0.7071, 0, 0.7071}},
                                                   {"front below", {0.8660, 0, -0.5}},
                                                   {"left", {0, 1, 0}},
                                                   {"right", {0, -1, 0}}}};

Waveform response_from(const Scene& scene, const Vector3& towards, const EulerAngles& head,
                       const HrtfSet& hrtf) {
  ThreadPool pool(1);
  const Vector3 listener{0.0, 0.0, 0.0};
  const Source source = omni(towards * 2.0);
  const TraceResult traced = trace(AcousticScene(scene), {&source, 1}, {&listener, 1},
                                   {.rays = 1000, .duration_s = 0.3}, pool);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 0.3});
  return synthesizer.binaural(traced.responses[0][0], quaternion_from_euler(head), hrtf, 0);
}

// The time at which a signal first exceeds a tenth of its peak.
double onset_ms(std::span<const float> signal) {
  float peak = 0.0F;
  for (const float sample : signal) peak = std::max(peak, std::abs(sample));
  const auto first = std::find_if(signal.begin(), signal.end(),
                                  [&](float sample) { return std::abs(sample) > 0.1F * peak; });
  return 1e3 * static_cast<double>(first - signal.begin()) / kRate_hz;
}

double level_difference_db(const Waveform& ears) {
  return decibels(energy(band_of(ears.channel(0), kRate_hz, 4000.0, 1.0)) /
                  energy(band_of(ears.channel(1), kRate_hz, 4000.0, 1.0)));
}

// Levels in dB of both ears, 1 to 14 kHz, in a frame that starts a little before the sound.
std::vector<double> colour(std::span<const float> left, std::span<const float> right) {
  constexpr int kSize = 1024;
  RealFft<float> fft(kSize);
  std::vector<std::complex<float>> spectrum(fft.bins());
  std::vector<double> levels_db;
  for (const std::span<const float> ear : {left, right}) {
    std::vector<float> frame(kSize);
    std::copy_n(ear.begin(), std::min<std::size_t>(ear.size(), kSize), frame.begin());
    fft.forward(frame, spectrum);
    for (int bin = 1000 * kSize / kRate_hz; bin < 14000 * kSize / kRate_hz; ++bin) {
      levels_db.push_back(decibels(static_cast<double>(std::norm(spectrum[bin])) + 1e-12));
    }
  }
  return levels_db;
}

double distance_db(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] - b[i];
  const double mean = sum / static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) squares += std::pow(a[i] - b[i] - mean, 2);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

GateRow side_row(const Direction& direction, double sign, const HrtfSet& hrtf) {
  const Waveform ears = response_from(open_air(), direction.towards, {}, hrtf);
  const double time_ms = onset_ms(ears.channel(1)) - onset_ms(ears.channel(0));
  const double level_db = level_difference_db(ears);
  // A head of 18 cm delays sound from the side by 0.5 to 0.8 ms and shadows 4 kHz by at least 5 dB.
  return {.gate = fmt::format("source on the {}: the left ear is ahead by, and louder at 4 kHz by",
                              direction.name),
          .measured = fmt::format("{:+.2f} ms, {:+.1f} dB", time_ms, level_db),
          .limit = sign > 0 ? "0.5 to 0.8 ms, above 5 dB" : "-0.8 to -0.5 ms, below -5 dB",
          .passed = sign * time_ms > 0.5 && sign * time_ms < 0.8 && sign * level_db > 5.0};
}

// The response from each direction is most like that direction's measured HRTF.
GateRow colour_row(const HrtfSet& hrtf) {
  double largest_own_db = 0.0;
  double smallest_other_db = std::numeric_limits<double>::infinity();
  const auto skip = static_cast<std::size_t>(
      std::floor(2.0 / speed_of_sound_m_per_s({}) * kRate_hz - hrtf.centre_delay_samples()));
  for (const Direction& direction : kDirections) {
    const Waveform ears = response_from(open_air(), direction.towards, {}, hrtf);
    const std::vector<double> heard =
        colour(ears.channel(0).subspan(skip), ears.channel(1).subspan(skip));
    for (const Direction& other : kDirections) {
      const std::size_t measurement = hrtf.nearest(other.towards);
      const double away_db =
          distance_db(heard, colour(hrtf.response(measurement, 0), hrtf.response(measurement, 1)));
      if (other.name == direction.name) {
        largest_own_db = std::max(largest_own_db, away_db);
      } else {
        smallest_other_db = std::min(smallest_other_db, away_db);
      }
    }
  }
  return {.gate =
              "front, back, above, below, left, right: spectral distance, 1 to 14 kHz, to the "
              "direction's own measured HRTF, and to the nearest other's",
          .measured = fmt::format("at most {:.2f} dB, at least {:.2f} dB", largest_own_db,
                                  smallest_other_db),
          // The measured direction is a few degrees off, and air attenuates the highest octave.
          .limit = "the first less than half the second",
          .passed = largest_own_db < 0.5 * smallest_other_db};
}

// Turning the head is the same as turning the world the other way, up to single precision. The
// difference of a wrong turn is as loud as the sound.
GateRow turn_row(const HrtfSet& hrtf) {
  struct Turn {
    EulerAngles head;
    Vector3 source;
    Vector3 same_as;
  };
  // To the left, up, and both at once with the source aside.
  const std::array<Turn, 3> turns = {
      {{{.yaw_rad = kPi / 2}, {0, 1, 0}, {1, 0, 0}},
       {{.pitch_rad = kPi / 4}, {1, 0, 0}, {0.70710678, 0, -0.70710678}},
       {{.yaw_rad = kPi}, {1, 0, 0}, {-1, 0, 0}}}};
  double worst_db = -std::numeric_limits<double>::infinity();
  for (const Turn& turn : turns) {
    const Waveform turned = response_from(open_air(), turn.source, turn.head, hrtf);
    const Waveform still = response_from(open_air(), turn.same_as, {}, hrtf);
    double error = 0.0;
    double all = 0.0;
    for (int ear = 0; ear < 2; ++ear) {
      for (std::ptrdiff_t i = 0; i < turned.samples(); ++i) {
        const double a = static_cast<double>(turned.channel(ear)[i]);
        const double b = static_cast<double>(still.channel(ear)[i]);
        error += (a - b) * (a - b);
        all += b * b;
      }
    }
    worst_db = std::max(worst_db, decibels(error / all));
  }
  return {.gate = "head turned left, up, round: difference to a source moved the other way",
          .measured = fmt::format("{:.0f} dB", worst_db),
          .limit = "-60 dB",
          .passed = worst_db < -60.0};
}

// Reflections and the late field also come from the right sides; of 10 dB in free field 3 to 4 dB
// are left (measured).
GateRow room_row(const HrtfSet& hrtf) {
  Scene room = make_shoebox({6, 5, 3}, all_bands(0.4F), all_bands(0.5F));
  for (auto& [x, y, z] : room.mesh.positions) {
    x -= 3.0F;
    y -= 2.5F;
    z -= 1.5F;
  }
  const double left_db = level_difference_db(response_from(room, {0, 1, 0}, {}, hrtf));
  const double right_db = level_difference_db(response_from(room, {0, -1, 0}, {}, hrtf));
  return {.gate = "the same in a room: left ear louder at 4 kHz, source on the left and right",
          .measured = fmt::format("{:+.1f} dB, {:+.1f} dB", left_db, right_db),
          .limit = "above 2 dB, below -2 dB",
          .passed = left_db > 2.0 && right_db < -2.0};
}

}  // namespace

std::vector<GateRow> ear_gate() {
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  return {side_row(kDirections[4], 1.0, hrtf), side_row(kDirections[5], -1.0, hrtf), room_row(hrtf),
          colour_row(hrtf), turn_row(hrtf)};
}

}  // namespace earpoint::gates
