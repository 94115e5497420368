#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/evaluate/reverberation_error.h>
#include <earpoint/network_testing/oracle_weights.h>
#include <earpoint/rt60/weights.h>

namespace earpoint {
namespace {

Rt60Estimator small_estimator() {
  Rt60EstimatorWeights weights{{2, {}}, {}, {}};
  for (const auto& [name, shape] : required_tensors(weights.description)) {
    const OracleRandom random(name, 1);
    std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
    const double low = name.ends_with("running_var") ? 0.5 : -0.5;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = random.value(i, low, 1.0);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return Rt60Estimator(weights);
}

Waveform noise(std::uint64_t seed, double left, double right) {
  Waveform sound(2, 16000, 16000);
  const OracleRandom random("noise", seed);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    sound.channel(0)[i] = random.value(i, -left, left);
    sound.channel(1)[i] = random.value(i, -right, right);
  }
  return sound;
}

TEST(ReverberationError, IsTheMeanOfTheEarsDifferences) {
  Rt60Estimator estimator = small_estimator();
  const Waveform a = noise(1, 0.5, 0.1);
  const Waveform b = noise(2, 0.1, 0.5);
  const std::vector<double> in_a = estimator.estimate_s(a);
  const std::vector<double> in_b = estimator.estimate_s(b);
  // The ears differ in opposite directions, so that a difference of means would be smaller.
  ASSERT_LT((in_a[0] - in_b[0]) * (in_a[1] - in_b[1]), 0.0);
  EXPECT_DOUBLE_EQ(reverberation_error_s(estimator, a, b),
                   (std::abs(in_a[0] - in_b[0]) + std::abs(in_a[1] - in_b[1])) / 2);
  EXPECT_EQ(reverberation_error_s(estimator, a, a), 0.0);
}

}  // namespace
}  // namespace earpoint
