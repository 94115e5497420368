#include <earpoint/evaluate/reverberation_error.h>

#include <cmath>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {

double reverberation_error_s(Rt60Estimator& estimator, const Waveform& reference,
                             const Waveform& estimate) {
  EARPOINT_CHECK(reference.channels() == estimate.channels());
  const std::vector<double> wanted = estimator.estimate_s(reference);
  const std::vector<double> found = estimator.estimate_s(estimate);
  double sum = 0.0;
  for (std::size_t c = 0; c < wanted.size(); ++c) sum += std::abs(wanted[c] - found[c]);
  return sum / static_cast<double>(wanted.size());
}

}  // namespace earpoint
