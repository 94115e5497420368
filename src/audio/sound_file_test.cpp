#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class SoundFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("sound_file_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] auto entries() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  fs::path folder_;
};

Waveform noise(int channels, std::ptrdiff_t samples, int rate_hz) {
  RandomStream random(7);
  Waveform wave(channels, samples, rate_hz);
  for (float& x : wave.planar()) x = static_cast<float>(random.uniform(-0.9, 0.9));
  return wave;
}

double largest_difference(const Waveform& a, const Waveform& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.planar().size(); ++i) {
    largest = std::max(largest, std::abs(double{a.planar()[i]} - b.planar()[i]));
  }
  return largest;
}

std::string message_of(const auto& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(SoundFile, LosslessFormatsGiveBackTheirSamples) {
  const Waveform wave = noise(2, 100000, 44100);
  for (const char* extension : {".wav", ".w64", ".flac", ".WAV"}) {
    for (const auto& [format, step] : {std::pair{SampleFormat::pcm16, 1.0 / 32768},
                                       {SampleFormat::pcm24, 1.0 / 8388608},
                                       {SampleFormat::float32, 0.0}}) {
      if (extension == std::string(".flac") && format == SampleFormat::float32) continue;
      const fs::path path = folder_ / (std::string("x") + extension);
      write_sound(path, wave, format);
      const SoundInfo info = probe_sound(path);
      EXPECT_EQ(info.channels, 2);
      EXPECT_EQ(info.sample_rate_hz, 44100);
      EXPECT_EQ(info.frames, 100000);
      // Rounding to the nearest step is at most half a step off.
      EXPECT_LE(largest_difference(wave, read_sound(path)), 0.5001 * step) << path;
    }
  }
}

}  // namespace
}  // namespace earpoint
