#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/kernels/phase_step.h>
#include <earpoint/kernels_testing/every_target.h>

namespace earpoint::kernels {
namespace {

TEST(PhaseStep, KeepsMagnitudesAndExtrapolatesPhasesOnEveryProcessor) {
  // No multiple of any vector's length.
  constexpr std::size_t kBins = 37;
  constexpr float kMomentum = 0.99F;
  constexpr float kFloor = 1e-9F;
  RandomStream random(1);
  std::vector<std::complex<float>> transform(kBins), before(kBins);
  std::vector<float> magnitude(kBins);
  for (std::size_t i = 0; i < kBins; ++i) {
    const auto draw = [&] { return static_cast<float>(random.uniform(-1.0, 1.0)); };
    transform[i] = {draw(), draw()};
    before[i] = {draw(), draw()};
    magnitude[i] = std::abs(draw());
  }
  for_every_target([&] {
    std::vector<std::complex<float>> turned = transform;
    std::vector<std::complex<float>> heard = before;
    step_phases(turned, heard, magnitude, kMomentum, kFloor);
    EXPECT_EQ(heard, transform);
    for (std::size_t i = 0; i < kBins; ++i) {
      const std::complex<double> now = transform[i];
      const std::complex<double> pushed =
          now + double{kMomentum} * (now - std::complex<double>(before[i]));
      const std::complex<double> expected = pushed * (magnitude[i] / std::abs(pushed));
      // Numbers of at most 1 in float32; the floor is 1e-6 of these powers and less.
      EXPECT_NEAR(turned[i].real(), expected.real(), 3e-6) << i;
      EXPECT_NEAR(turned[i].imag(), expected.imag(), 3e-6) << i;
    }
  });
}

TEST(PhaseStep, LeavesSilenceSilent) {
  std::vector<std::complex<float>> transform(5), heard(5);
  step_phases(transform, heard, std::vector<float>(5, 0.0F), 0.99F, 1e-12F);
  for (const std::complex<float> value : transform) EXPECT_EQ(std::abs(value), 0.0F);
}

}  // namespace
}  // namespace earpoint::kernels
