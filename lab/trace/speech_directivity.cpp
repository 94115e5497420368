#include <array>
#include <cmath>
#include <vector>

#include <earpoint/trace/source.h>

namespace earpoint {
namespace {

constexpr int kAngles = 13;  // every 15 degrees, from the front to the back
constexpr int kMeasuredBands = 7;

// Level in dB relative to the front, octave bands from 125 Hz to 8 kHz: Monson, Hunter and Story,
// JASA 132(1), 433-441 (2012), doi 10.1121/1.4725963, Table I, normal speech. Taken from a
// transcription, which agrees with a second one in every digit; not compared with the paper itself.
constexpr std::array<std::array<double, kMeasuredBands>, kAngles> kLevels_db = {{
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {0.8, 0.7, 0.6, -0.2, -1.0, -1.7, -1.0},
    {-0.1, -0.2, 0.1, -0.7, -0.1, -0.7, -1.7},
    {-0.4, -0.5, 0.0, -1.4, -0.8, -1.6, -3.1},
    {-0.6, -0.8, -0.1, -1.5, -2.5, -3.9, -5.8},
    {-1.1, -1.6, -0.7, -1.4, -4.7, -5.3, -7.0},
    {-1.6, -2.3, -1.6, -1.6, -7.0, -6.3, -8.7},
    {-2.1, -3.1, -2.8, -2.5, -7.6, -9.0, -11.5},
    {-2.7, -3.9, -4.4, -4.6, -7.9, -12.7, -15.0},
    {-3.1, -4.5, -5.5, -7.0, -9.3, -14.5, -17.8},
    {-3.5, -4.9, -6.0, -7.9, -13.0, -16.7, -21.5},
    {-3.6, -5.0, -6.0, -6.9, -15.0, -21.0, -25.0},
    {-3.6, -5.1, -5.9, -6.3, -13.1, -18.9, -26.3},
}};
static_assert(kMeasuredBands + 1 == kOctaveBands);

}  // namespace

Directivity speech_directivity() {
  std::vector<BandArray> energies;
  for (const auto& levels_db : kLevels_db) {
    BandArray& bands = energies.emplace_back();
    for (int band = 0; band < kOctaveBands; ++band) {
      const double level_db = levels_db[band > 0 ? band - 1 : 0];
      bands[band] = static_cast<float>(std::pow(10.0, level_db / 10.0));
    }
  }
  return Directivity::about_front(std::move(energies));
}

}  // namespace earpoint
