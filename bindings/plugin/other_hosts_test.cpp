// The LV2 bundle in programs of others, moved to a folder of its own as a user would: ffmpeg,
// lv2apply, lv2ls, lv2info and lv2_validate. Each test is skipped where its program is not
// installed.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/audio/stft.h>
#include <earpoint/core/temporary_folder.h>
#include <earpoint/renderer.h>
#include <earpoint/waveform.h>

#include "bundled_clip.h"

namespace earpoint::plugin {
namespace {

namespace fs = std::filesystem;

#define SKIP_WITHOUT(program) \
  if (find_program(program).empty()) GTEST_SKIP() << program " is not installed"

class OtherHosts : public ::testing::Test {
 protected:
  OtherHosts() {
    // Copied with its models, which are links in the build tree.
    fs::create_directories(bundle_ / "models");
    for (const auto& file : fs::directory_iterator(EARPOINT_PLUGIN_DIR "/lv2/earpoint.lv2")) {
      if (file.is_regular_file()) fs::copy(file.path(), bundle_);
    }
    for (const char* model : {"gtf.safetensors", "enhance.safetensors"}) {
      fs::copy(fs::path(EARPOINT_SOURCE_DIR "/models") / model, bundle_ / "models");
    }
  }

  /// With that bundle alone, far from the build tree.
  std::string run(const std::string& command) const {
    return run_command("cd " + folder_.path().string() +
                       " && export LV2_PATH=" + folder_.path().string() +
                       ":/usr/lib/lv2 && unset EARPOINT_MODELS_DIR && " + command);
  }

  TemporaryFolder folder_;
  fs::path bundle_ = folder_.path() / "earpoint.lv2";
};

/// What the bundled clip's first earpoint is in the plugin's parameters.
std::vector<std::pair<std::string, std::string>> bundled_parameters() {
  return {{"earpoint_x", "1.49"}, {"earpoint_y", "-0.2"}, {"yaw", "-45"},
          {"speaker_given", "1"}, {"speaker_x", "1.89"},  {"speaker_y", "0.196"},
          {"speaker_z", "0.147"}};
}

std::string ffmpeg_filter() {
  std::string controls;
  for (const auto& [symbol, value] : bundled_parameters()) {
    controls += (controls.empty() ? "" : "|") + symbol + "=" + value;
  }
  return R"(lv2=p=urn\\:earpoint\\:plugin:c=)" + controls;
}

TEST_F(OtherHosts, FfmpegGivesTheLibrarysStreamOfARealClip) {
  SKIP_WITHOUT("ffmpeg");
  run("ffmpeg -v error -i " EARPOINT_SOURCE_DIR "/examples/clip.mp4 -vn -af '" + ffmpeg_filter() +
      "' -c:a pcm_f32le there.wav");
  const Waveform there = read_sound(folder_.path() / "there.wav");
  const Waveform expected = stream_of_library("gtf", bundled_settings(), bundled_clip());
  ASSERT_EQ(there.samples(), expected.samples());
  EXPECT_TRUE(same(there, expected));
}

/// Mean difference of magnitudes, as a part of the second sound's.
double spectral_distance(const Waveform& a, const Waveform& b) {
  Stft stft({.fft_size = 1536, .window_size = 1200, .hop = 480});
  double difference = 0.0;
  double whole = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    const Spectrogram of_a = stft.forward(a.channel(ear));
    const Spectrogram of_b = stft.forward(b.channel(ear));
    for (std::size_t i = 0; i < of_a.values.size(); ++i) {
      difference += std::abs(std::abs(of_a.values[i]) - std::abs(of_b.values[i]));
      whole += std::abs(of_b.values[i]);
    }
  }
  return difference / whole;
}

double level_db(const Waveform& sound, int ear) {
  return 10.0 * std::log10(energy(sound.channel(ear)));
}

TEST_F(OtherHosts, FfmpegGivesNearlyWhatTheProgramRenders) {
  SKIP_WITHOUT("ffmpeg");
  if (!fs::exists(EARPOINT_PROGRAM)) GTEST_SKIP() << "the program is not built";
  write_sound(folder_.path() / "here.wav", bundled_clip(), SampleFormat::float32);
  run("ffmpeg -v error -i here.wav -af '" + ffmpeg_filter() + "' -c:a pcm_f32le live.wav");
  // Without the picture, which a plugin does not see.
  run_command("cd " + folder_.path().string() +
              " && EARPOINT_MODELS_DIR=" EARPOINT_SOURCE_DIR "/models " EARPOINT_PROGRAM
              " render here.wav --speaker 1.89,0.196,0.147 "
              "--translate 1.49,-0.2,0 --yaw -45 --quiet -o whole.wav");
  const Waveform live = read_sound(folder_.path() / "live.wav");
  const Waveform whole = read_sound(folder_.path() / "whole.wav");
  ASSERT_EQ(live.samples(), whole.samples());
  const std::ptrdiff_t late =
      Renderer::open("gtf").stream({.sample_rate_hz = 48000}).latency_samples();
  const std::ptrdiff_t length = live.samples() - late;
  const Waveform heard = part_of(live, late, length);
  const Waveform wanted = part_of(whole, 0, length);
  const Waveform source = part_of(bundled_clip(), 0, length);
  // A stream knows the last second where `render` knows the whole clip, and splits ambient sound by
  // a causal crossover. Measured: 0.13, and 0.34 dB in level; the unmoved sound is 0.46 away.
  EXPECT_LT(spectral_distance(heard, wanted), 0.25);
  EXPECT_GT(spectral_distance(source, wanted), 0.4);
  for (int ear = 0; ear < 2; ++ear) EXPECT_NEAR(level_db(heard, ear), level_db(wanted, ear), 0.6);
}

TEST_F(OtherHosts, FfmpegGetsItsSoundBackWithoutModels) {
  SKIP_WITHOUT("ffmpeg");
  const std::string said =
      run("mkdir empty && export EARPOINT_MODELS_DIR=$PWD/empty && ffmpeg -v error "
          "-i " EARPOINT_SOURCE_DIR "/examples/clip.mp4 -vn -af '" +
          ffmpeg_filter() + "' -c:a pcm_f32le there.wav");
  EXPECT_NE(said.find("models: none is installed"), std::string::npos) << said;
  EXPECT_TRUE(same(read_sound(folder_.path() / "there.wav"), bundled_clip()));
}

TEST_F(OtherHosts, Lv2applyGivesTheLibrarysStream) {
  SKIP_WITHOUT("lv2apply");
  const Waveform sound = part_of(bundled_clip(), 0, 48000);
  write_sound(folder_.path() / "here.wav", sound, SampleFormat::float32);
  std::string controls;
  for (const auto& [symbol, value] : bundled_parameters()) {
    controls += " -c " + symbol + " " + value;
  }
  run("lv2apply -i here.wav -o there.wav" + controls + " urn:earpoint:plugin");
  const Waveform there = read_sound(folder_.path() / "there.wav");
  const Waveform expected = stream_of_library("gtf", bundled_settings(), sound);
  EXPECT_TRUE(same(there, expected));
}

TEST_F(OtherHosts, Lv2lsAndLv2infoKnowIt) {
  SKIP_WITHOUT("lv2ls");
  EXPECT_NE(run("lv2ls").find("urn:earpoint:plugin\n"), std::string::npos);
  const std::string info = run("lv2info urn:earpoint:plugin");
  for (const char* text :
       {"Earpoint", "earpoint_x", "lv2_latency", "gtf", "enhance", "Speaker given"}) {
    EXPECT_NE(info.find(text), std::string::npos) << text << " is not in\n" << info;
  }
}

TEST_F(OtherHosts, ItsDescriptionIsValid) {
  SKIP_WITHOUT("lv2_validate");
  SKIP_WITHOUT("sord_validate");
  // It fails if there is an error.
  const std::string report =
      run("lv2_validate earpoint.lv2/manifest.ttl earpoint.lv2/earpoint.ttl");
  EXPECT_NE(report.find("Found 0 errors"), std::string::npos) << report;
}

}  // namespace
}  // namespace earpoint::plugin
