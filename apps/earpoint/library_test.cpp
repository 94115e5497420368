#include "gtf_file.h"
#include "run_program.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>
#include <earpoint/renderer.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// Renders the same by the program and by the library.
class LibraryAndProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("library_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write_gtf_file(at("gtf.safetensors"));
    RandomStream random(7);
    for (std::uint8_t& value : picture_.pixels()) {
      value = static_cast<std::uint8_t>(random.uniform(0.0, 255.0));
    }
    write_image(at("frame.png"), picture_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string at(const char* name) const { return (folder_ / name).string(); }

  Waveform sound(int channels, int rate_hz) {
    Waveform wave(channels, std::lround(1.3 * rate_hz), rate_hz);
    RandomStream random(5);
    for (float& sample : wave.planar()) sample = static_cast<float>(0.05 * random.normal());
    write_sound(at("in.wav"), wave, SampleFormat::float32);
    return wave;
  }

  /// The output of the program.
  Waveform program(const std::vector<std::string>& arguments, const std::string& model) const {
    std::vector<std::string> all{"render",     at("frame.png"), at("in.wav"), "--model", model,
                                 "-o",         at("out.wav"),   "--quiet",    "--fov",   "80",
                                 "--detector", "none"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const ProgramOutcome outcome = run_earpoint(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return read_sound(at("out.wav"));
  }

  [[nodiscard]] static Renderer renderer(const std::string& model) {
    return Renderer::open(model, {.horizontal_fov_rad = radians_from_degrees(80.0)});
  }

  static void expect_same(const Waveform& a, const Waveform& b) {
    EXPECT_EQ(a.sample_rate_hz(), b.sample_rate_hz());
    ASSERT_EQ(a.samples(), b.samples());
    EXPECT_TRUE(std::ranges::equal(a.planar(), b.planar()));
    EXPECT_TRUE(std::ranges::any_of(a.planar(), [](float x) { return std::abs(x) > 1e-3F; }));
  }

  fs::path folder_;
  Image picture_{64, 48, 3};
};

TEST_F(LibraryAndProgram, GiveTheSameSamplesWithPictureAndBoxAtRatesWithAndWithoutABandAbove) {
  const std::string model = at("gtf.safetensors");
  for (const int rate_hz : {16000, 44100}) {
    const Waveform heard = sound(2, rate_hz);
    const Pose there{{1.0, -0.5, 0.1},
                     quaternion_from_euler({radians_from_degrees(30.0), 0.0, 0.0})};
    const Waveform ours = renderer(model).render(
        heard, {.picture = &picture_, .speaker_box = Box{0.4, 0.3, 0.6, 0.9}, .target = there});
    expect_same(program({"--speaker-box", "0.4,0.3,0.6,0.9", "--translate", "1,-0.5,0.1", "--yaw",
                         "30", "--recording", "binaural"},
                        model),
                ours);
  }
}

TEST_F(LibraryAndProgram, GiveTheSameSamplesAlongAPath) {
  const Waveform heard = sound(2, 48000);
  write_file(at("walk.csv"),
             "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,0,0,0,0,0,0\n2,1,1,0,0,0,0\n");
  const Waveform ours = renderer(at("gtf.safetensors"))
                            .render(heard, {.picture = &picture_,
                                            .speaker_m = Vector3{2, 0.5, 0},
                                            .path = {{0.0, {}}, {2.0, {{1, 1, 0}, {}}}}});
  expect_same(program({"--speaker", "2,0.5,0", "--path", at("walk.csv"), "--recording", "binaural"},
                      at("gtf.safetensors")),
              ours);
}

TEST_F(LibraryAndProgram, GiveTheSameSamplesOfOneChannelAndByHeadFilters) {
  const Waveform heard = sound(1, 44100);
  const Waveform ours = renderer("dsp").render(
      heard, {.picture = &picture_, .speaker_m = Vector3{2, 0.5, 0}, .target = {{0, 1, 0}, {}}});
  expect_same(program({"--speaker", "2,0.5,0", "--translate", "0,1,0"}, "dsp"), ours);
}

}  // namespace
}  // namespace earpoint
