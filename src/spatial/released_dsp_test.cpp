#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/spatial/released_dsp.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

class ReleasedDspOracle : public testing::Test {
 protected:
  ReleasedDspOracle()
      : file_(read_safetensors(std::filesystem::path(EARPOINT_SOURCE_DIR) /
                               "src/spatial/testdata/released_hrtf.safetensors")) {
    const auto positions = file_.tensors.at("positions").as<double>();
    for (std::size_t i = 0; i < positions.size(); i += 3) {
      angles_.push_back({positions[i], positions[i + 1]});
    }
    const Tensor& binaural = file_.tensors.at("binaural");
    binaural_ = Waveform(2, binaural.shape[1], 16000);
    std::ranges::copy(binaural.as<float>(), binaural_.planar().begin());
  }

  [[nodiscard]] ReleasedDsp::Position query(int index) const {
    const auto all = file_.tensors.at("query").as<double>();
    return {all[3 * index], all[3 * index + 1], all[3 * index + 2]};
  }

  void expect_near(std::span<const float> found, const std::string& name) const {
    const auto expected = file_.tensors.at(name).as<float>();
    ASSERT_EQ(found.size(), expected.size()) << name;
    float scale = 1.0F;
    for (const float value : expected) scale = std::max(scale, std::abs(value));
    for (std::size_t i = 0; i < found.size(); ++i) {
      // The oracle's sums of 96 products are float32: 1e-6 of the largest value.
      ASSERT_NEAR(found[i], expected[i], 1e-6F * scale) << name << " at " << i;
    }
  }

  SafetensorsFile file_;
  std::vector<std::array<double, 2>> angles_;
  Waveform binaural_;
};

TEST_F(ReleasedDspOracle, MatchesTheReleasedCode) {
  const auto responses = file_.tensors.at("ir").as<float>();
  const ReleasedDsp dsp(angles_, responses, 96);
  for (int i = 0; i < 5; ++i) {
    const ReleasedDsp::Position there = query(i);
    const std::vector<float> mono = dsp.apply_inverse(binaural_, there);
    expect_near(mono, fmt::format("inv{}", i));
    expect_near(dsp.apply(binaural_.channel(0), there, 16000).planar(), fmt::format("fwd{}", i));
    const ReleasedDsp::Position target{there.azimuth_deg + 40.0, there.elevation_deg,
                                       1.3 * there.distance_m};
    expect_near(dsp.apply(mono, target, 16000).planar(), fmt::format("fwd_of_inv{}", i));
  }
}

TEST_F(ReleasedDspOracle, RefusesAPairOfAnglesThatWasNotMeasured) {
  const std::vector<std::array<double, 2>> angles = {{0.0, 0.0}, {30.0, 20.0}};
  const ReleasedDsp dsp(angles, file_.tensors.at("ir").as<float>().first(4 * 96), 96);
  EXPECT_THROW(static_cast<void>(dsp.apply(binaural_.channel(0), {29.0, 1.0, 1.0}, 16000)),
               InputError);
}

TEST(ReleasedDsp, GainIsClampedWithinAnArmsLength) {
  EXPECT_EQ(ReleasedDsp::gain(0.05), 1.0);
  EXPECT_NEAR(ReleasedDsp::gain(2.0), 0.1, 1e-15);
}

TEST(ReleasedDsp, TakesWholeDegreesOfASofaFile) {
  const ReleasedDsp dsp(read_sofa(default_hrtf_path()));
  const std::vector<float> click = {1.0F};
  // 0.9 of a degree short of the next one listed at this elevation; 345 is listed, 360 is not.
  EXPECT_EQ(dsp.apply(click, {359.0, 0.0, 0.2}, 44100).samples(), 2);
  // Azimuth 5 is listed, but not at elevation -40.
  EXPECT_THROW(static_cast<void>(dsp.apply(click, {5.0, -40.0, 0.2}, 44100)), InputError);
}

}  // namespace
}  // namespace earpoint
