#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/random.h>
#include <earpoint/earpoint.h>
#include <earpoint/gtf/description.h>
#include <earpoint/network/weights.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/waveform.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A folder of shipped models that holds one small network that was never trained, `gtf`.
class TestModel : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    GtfDescription description;
    description.channels = 8;
    description.layers = 2;
    description.bands = 10;
    description.picture_px = 32;
    description.window_samples = 4000;
    description.highpass_cutoff_hz = 80.0;
    write_safetensors(folder_ / "gtf.safetensors", to_weight_file(random_gtf_weights(description)));
    ::setenv("EARPOINT_MODELS_DIR", folder_.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("EARPOINT_MODELS_DIR");
    std::filesystem::remove_all(folder_);
  }

  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("c_api_test_" + std::to_string(::getpid()));
};

/// Noise of two ears as C and C++ take it.
struct TestSound {
  TestSound(int channels, double duration_s, int rate_hz)
      : waveform(channels, std::lround(duration_s * rate_hz), rate_hz) {
    RandomStream random(5);
    for (float& sample : waveform.planar()) sample = static_cast<float>(0.05 * random.normal());
    for (int i = 0; i < channels; ++i) pointers.push_back(waveform.channel(i).data());
    sound = {pointers.data(), channels, static_cast<std::size_t>(waveform.samples()), rate_hz};
  }
  TestSound(const TestSound&) = delete;
  TestSound& operator=(const TestSound&) = delete;

  Waveform waveform;
  std::vector<const float*> pointers;
  earpoint_sound sound{};
};

/// Where C writes two ears.
struct TestEars {
  explicit TestEars(const TestSound& like)
      : waveform(2, like.waveform.samples(), like.waveform.sample_rate_hz()) {}
  [[nodiscard]] float* const* out() { return pointers; }

  Waveform waveform;
  float* pointers[2] = {waveform.channel(0).data(), waveform.channel(1).data()};
};

/// A grey picture with one odd pixel, and rows that are longer than its width.
struct TestPicture {
  static constexpr int kWidth = 32;
  static constexpr int kHeight = 24;
  static constexpr std::size_t kRow_bytes = 3 * kWidth + 5;

  TestPicture() { pixels[3 * 4 + kRow_bytes * 7 + 1] = 255; }

  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kRow_bytes * kHeight, 90);
  earpoint_picture picture{pixels.data(), kWidth, kHeight, kRow_bytes};
};

}  // namespace earpoint
