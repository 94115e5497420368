#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/render/render_in_memory.h>
#include <earpoint/render_files/render.h>
#include <earpoint/synthesis/input_synthesizer.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A network that copies: its own rate, windows, context and ambient split, like a real one.
class IdentityNetwork : public AcousticSynthesizer {
 public:
  explicit IdentityNetwork(double ambient_cutoff_hz = 0.0) : cutoff_hz_(ambient_cutoff_hz) {}
  [[nodiscard]] WindowShape window_shape(int) const override {
    return {.sample_rate_hz = 16000, .samples = 16000, .overlap = 4000, .context = 128};
  }
  [[nodiscard]] double ambient_cutoff_hz() const override { return cutoff_hz_; }
  void observe(const Observation& observation) override {
    sound_ = Waveform(2, 16000, 16000);
    EXPECT_EQ(observation.sound.samples(), 16000 + 2 * 128);
    for (int ear = 0; ear < 2; ++ear) {
      std::copy_n(observation.sound.channel(ear).begin() + 128, 16000, sound_.channel(ear).begin());
    }
  }
  [[nodiscard]] Waveform synthesize(const Pose& pose) override {
    Waveform result = sound_;
    for (float& sample : result.planar()) sample *= static_cast<float>(pose.position_m.x);
    return result;
  }

 private:
  double cutoff_hz_;
  Waveform sound_;
};

class RenderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) /
        (std::string("render_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path write(const Waveform& sound, const char* name = "in.wav") const {
    write_sound(folder_ / name, sound, SampleFormat::float32);
    return folder_ / name;
  }

  [[nodiscard]] Waveform rendered(const fs::path& input, AcousticSynthesizer& synthesizer,
                                  const ClipRenderOptions& options = {}, double gain = 1.0) const {
    const std::vector<RenderTarget> targets = {
        {EarpointPath(Pose{{gain, 0, 0}, {}}), folder_ / "out.wav"}};
    RenderInput source;
    source.sound.path = input;
    SilentProgress progress;
    (void)render(source, synthesizer, targets, options, progress);
    return read_sound(folder_ / "out.wav");
  }

  [[nodiscard]] std::string error_of(const fs::path& input) const {
    IdentityNetwork network;
    try {
      (void)rendered(input, network);
    } catch (const InputError& error) {
      EXPECT_FALSE(fs::exists(folder_ / "out.wav"));
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
};

Waveform tone(double frequency_hz, double duration_s, int rate_hz) {
  Waveform sound(2, std::lround(duration_s * rate_hz), rate_hz);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const double phase = 2 * kPi * frequency_hz * static_cast<double>(i) / rate_hz;
    sound.channel(0)[i] = static_cast<float>(0.5 * std::sin(phase));
    sound.channel(1)[i] = static_cast<float>(0.25 * std::cos(phase));
  }
  return sound;
}

Waveform noise(double duration_s, int rate_hz) {
  Waveform sound(2, std::lround(duration_s * rate_hz), rate_hz);
  RandomStream random(5);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.1 * random.normal());
  return sound;
}

double greatest_difference(const Waveform& a, const Waveform& b) {
  EXPECT_EQ(a.samples(), b.samples());
  double greatest = 0.0;
  for (std::size_t i = 0; i < a.planar().size(); ++i) {
    greatest = std::max(greatest, std::abs(static_cast<double>(a.planar()[i]) - b.planar()[i]));
  }
  return greatest;
}

constexpr double kMinus60dB = 1e-3;  // of full scale: inaudible beside these tones

TEST_F(RenderTest, InputCopiesTheRecordingSampleForSample) {
  const Waveform sound = noise(2.37, 44100);
  InputSynthesizer copy;
  EXPECT_EQ(greatest_difference(rendered(write(sound), copy), sound), 0.0);
}

TEST_F(RenderTest, ASoundInMemoryIsRenderedAsItsFile) {
  for (const int rate : {16000, 44100}) {
    const Waveform sound = noise(3.4, rate);
    IdentityNetwork network(80.0);
    const Waveform of_file = rendered(write(sound), network, {}, 0.7);
    const SoundInMemory source{.sound = sound,
                               .picture = nullptr,
                               .speaker_box = {},
                               .speaker_m = {},
                               .world_from_source = {}};
    const Waveform in_memory =
        render_in_memory(source, network, EarpointPath(Pose{{0.7, 0, 0}, {}}), {});
    EXPECT_EQ(greatest_difference(in_memory, of_file), 0.0);
  }
}

TEST_F(RenderTest, AVoiceIsOneChannelWithoutAmbientSound) {
  Waveform sound = tone(997.0, 2.5, 16000);
  const Waveform hum = tone(30.0, 2.5, 16000);
  for (std::size_t i = 0; i < sound.planar().size(); ++i) sound.planar()[i] += hum.planar()[i];
  IdentityNetwork network(80.0);
  ClipRenderOptions options;
  options.answer = RenderAnswer::voice;
  const Waveform voice = rendered(write(sound), network, options);
  ASSERT_EQ(voice.channels(), 1);
  ASSERT_EQ(voice.samples(), sound.samples());
  const Waveform clean = tone(997.0, 2.5, 16000);
  double greatest = 0.0;
  for (std::ptrdiff_t i = 1600; i < voice.samples() - 1600; ++i) {
    const double expected = 0.5 * (clean.channel(0)[i] + clean.channel(1)[i]);
    greatest = std::max(greatest, std::abs(voice.channel(0)[i] - expected));
  }
  // At 30 Hz the order-5 high-pass at 80 Hz, run both ways, has an attenuation of 85 dB.
  EXPECT_LT(greatest, kMinus60dB);
}

TEST_F(RenderTest, NoiseThatIsAmbientPassesTheNetworkBy) {
  const Waveform sound = noise(4.0, 16000);
  IdentityNetwork network(80.0);
  ClipRenderOptions options;
  options.ambient = AmbientSeparation::mmse;
  // The network makes its sound ten times weaker: the ambient sound is left, which is almost all of
  // a steady noise.
  const Waveform result = rendered(write(sound), network, options, 0.1);
  double left = 0.0;
  double all = 0.0;
  for (std::ptrdiff_t i = 32000; i < 60000; ++i) {
    left += std::pow(result.channel(0)[i] - sound.channel(0)[i], 2);
    all += std::pow(sound.channel(0)[i], 2);
  }
  // 0.9 of the primary sound is missing, which is 20 dB below the noise.
  EXPECT_LT(10.0 * std::log10(left / all), -15.0);
}

TEST_F(RenderTest, ASteadyToneThroughAnIdentityNetworkHasNoClicks) {
  for (const int rate : {16000, 44100, 48000}) {
    const Waveform sound = tone(997.0, 5.3, rate);
    IdentityNetwork network(80.0);
    const Waveform result = rendered(write(sound), network);
    ASSERT_EQ(result.samples(), sound.samples()) << rate;
    ASSERT_EQ(result.sample_rate_hz(), rate);
    // -60 dB of the tone's amplitude, which covers clicks as well as steps. The first and last 20
    // ms are left out, as a resampler may ring at the recording's abrupt ends.
    const auto edge = rate / 50;
    for (int ear = 0; ear < 2; ++ear) {
      for (std::ptrdiff_t i = edge; i < sound.samples() - edge; ++i) {
        ASSERT_NEAR(result.channel(ear)[i], sound.channel(ear)[i], 0.5 * kMinus60dB)
            << rate << " Hz, sample " << i;
      }
    }
  }
}

TEST_F(RenderTest, AFullBandRecordingStaysFullBand) {
  const Waveform sound = noise(3.1, 48000);
  IdentityNetwork network;
  const Waveform result = rendered(write(sound), network);
  // White noise up to 24 kHz is preserved: the low band through the network, the rest beside it.
  // The gain of the top octave is measured on equal windows; resampling changes it by less than a
  // thousandth. Peaks of the noise are 0.45.
  EXPECT_LT(greatest_difference(result, sound), 5e-3);
}

TEST_F(RenderTest, TheBandAboveTheModelFollowsItsGain) {
  const Waveform sound = tone(12000.0, 3.0, 48000);
  Waveform both = tone(6000.0, 3.0, 48000);
  for (std::size_t i = 0; i < both.planar().size(); ++i) both.planar()[i] += sound.planar()[i];
  IdentityNetwork network;
  const Waveform result = rendered(write(both), network, {}, 0.5);
  ClipRenderOptions model_band;
  model_band.extend_band = false;
  const Waveform model_only = rendered(write(both), network, model_band, 0.5);
  for (std::ptrdiff_t i = 4800; i < sound.samples() - 4800; ++i) {
    ASSERT_NEAR(result.channel(0)[i], 0.5 * both.channel(0)[i], kMinus60dB);
    ASSERT_NEAR(model_only.channel(0)[i], 0.5 * (both.channel(0)[i] - sound.channel(0)[i]),
                kMinus60dB);
  }
}

TEST_F(RenderTest, AmbientSoundBypassesTheNetwork) {
  // 30 Hz is ambient below a cut-off of 80 Hz, 1 kHz is not.
  const Waveform low = tone(30.0, 4.0, 16000);
  const Waveform high = tone(1000.0, 4.0, 16000);
  Waveform both = low;
  for (std::size_t i = 0; i < both.planar().size(); ++i) both.planar()[i] += high.planar()[i];
  IdentityNetwork network(80.0);
  const Waveform result = rendered(write(both), network, {}, 0.0);
  // The order-5 filter, run both ways, leaves (30/80)^10 = 5e-5 of a 30 Hz tone's amplitude; -60 dB
  // of full scale is allowed.
  for (std::ptrdiff_t i = 8000; i < low.samples() - 8000; ++i) {
    ASSERT_NEAR(result.channel(0)[i], low.channel(0)[i], 1e-3) << i;
  }
}

TEST_F(RenderTest, WindowsAreCutAsIfTheWholeClipWereFilteredAtOnce) {
  // Nothing at Nyquist, as in any recording: the band-pass ends one hertz below it, and so sharp an
  // edge rings for seconds on any sound there.
  Waveform sound = noise(6.0, 16000);
  for (int ear = 0; ear < 2; ++ear) {
    const auto samples = sound.channel(ear);
    for (std::ptrdiff_t i = sound.samples() - 1; i > 1; --i) {
      samples[i] = (samples[i] + 2 * samples[i - 1] + samples[i - 2]) / 4;
    }
  }
  IdentityNetwork network(80.0);
  const Waveform silenced = rendered(write(sound), network, {}, 0.0);
  const auto sections = butterworth_bandpass(80.0, 7999.0, 16000.0);
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<double> input(sound.channel(ear).begin(), sound.channel(ear).end());
    std::vector<double> primary(input.size());
    filter_zero_phase(sections, input, primary);
    for (std::size_t i = 0; i < input.size(); ++i) {
      // The margin of 0.25 s leaves the transients of the low edge below -120 dB; the sound that
      // smoothing has left near Nyquist rings at -80 dB re the noise.
      ASSERT_NEAR(silenced.channel(ear)[i], input[i] - primary[i], 1e-5) << i;
    }
  }
}

TEST_F(RenderTest, SeveralTargetsShareOneReading) {
  const Waveform sound = noise(2.0, 16000);
  const fs::path input = write(sound);
  const std::vector<RenderTarget> targets = {
      {EarpointPath(Pose{{1.0, 0, 0}, {}}), folder_ / "a.wav"},
      {EarpointPath(Pose{{0.5, 0, 0}, {}}), folder_ / "b.flac"}};
  RenderInput source;
  source.sound.path = input;
  IdentityNetwork network;
  SilentProgress progress;
  const RenderReport report = render(source, network, targets, {}, progress);
  ASSERT_EQ(report.targets.size(), 2U);
  // Half of the amplitude, 6.0206 dB; the flac has 16 bits, noise 70 dB below this sound.
  EXPECT_NEAR(report.targets[0].level_db(0) - report.targets[1].level_db(0), 6.02, 0.01);
  EXPECT_NEAR(report.source.level_db(1), report.survey.level_db[1], 1e-6);
  EXPECT_LT(greatest_difference(read_sound(folder_ / "a.wav"), sound), 1e-6);
}

TEST_F(RenderTest, ReadingAheadChangesNoSample) {
  const fs::path input = write(noise(5.3, 44100));
  IdentityNetwork network(80.0);
  ClipRenderOptions options;
  const Waveform alone = rendered(input, network, options, 0.5);
  options.threads = 2;
  const Waveform ahead = rendered(input, network, options, 0.5);
  EXPECT_EQ(greatest_difference(alone, ahead), 0.0);
}

TEST_F(RenderTest, OutputStaysWithinFullScaleUnlessThatIsNotWished) {
  const Waveform sound = noise(2.0, 16000);
  RenderInput source;
  source.sound.path = write(sound);
  const std::vector<RenderTarget> targets = {
      {EarpointPath(Pose{{1, 0, 0}, {}}), folder_ / "o.wav"}};
  IdentityNetwork network;
  SilentProgress progress;
  ClipRenderOptions options;
  options.gain_db = 26.0;
  const RenderReport limited = render(source, network, targets, options, progress);
  EXPECT_LE(limited.targets[0].peak(), 1.0);
  const Waveform written = read_sound(folder_ / "o.wav");
  EXPECT_EQ(written.samples(), sound.samples());

  options.limit = false;
  const RenderReport whole = render(source, network, targets, options, progress);
  EXPECT_GT(whole.targets[0].peak(), 5.0);
  EXPECT_EQ(whole.limited_db[0], 0.0);
  // Peak and gain are floats: 6e-8 of either, 1e-6 dB.
  EXPECT_NEAR(limited.limited_db[0], 20.0 * std::log10(whole.targets[0].peak()), 1e-4);
  // The limited sound is the same with another gain: every sample keeps its sign.
  const Waveform loud = read_sound(folder_ / "o.wav");
  for (std::size_t i = 0; i < loud.planar().size(); ++i) {
    ASSERT_GE(loud.planar()[i] * written.planar()[i], 0.0F) << i;
  }
}

TEST_F(RenderTest, BadRecordingsGetOneLineAndLeaveNothing) {
  EXPECT_NE(error_of(folder_ / "missing.wav").find("missing.wav"), std::string::npos);

  EXPECT_EQ(error_of(write(Waveform(2, 16000, 16000))),
            (folder_ / "in.wav").string() +
                ": is silent from end to end; check the recording's level and channels");

  EXPECT_NE(error_of(write(noise(1.0, 8000))).find("has a sample rate of 8000 Hz"),
            std::string::npos);
  EXPECT_NE(error_of(write(noise(0.05, 16000))).find("lasts 0.050 s"), std::string::npos);

  std::ofstream(folder_ / "empty.wav").flush();
  EXPECT_NE(error_of(folder_ / "empty.wav").find("empty.wav"), std::string::npos);

  std::ofstream(folder_ / "text.wav") << "this is no sound";
  EXPECT_NE(error_of(folder_ / "text.wav").find("text.wav"), std::string::npos);
}

TEST_F(RenderTest, AnUnwritableOrUnknownOutputIsNamedBeforeTheWork) {
  const fs::path input = write(noise(1.0, 16000));
  RenderInput source;
  source.sound.path = input;
  InputSynthesizer copy;
  SilentProgress progress;
  const auto error = [&](const std::vector<fs::path>& outputs) {
    std::vector<RenderTarget> targets;
    for (const fs::path& output : outputs) targets.push_back({EarpointPath(Pose{}), output});
    try {
      (void)render(source, copy, targets, {}, progress);
    } catch (const InputError& problem) {
      return std::string(problem.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(error({folder_ / "no" / "out.wav"}).find("folder does not exist"), std::string::npos);
  EXPECT_NE(error({folder_ / "out.xyz"}).find("cannot write '.xyz' files"), std::string::npos);
  EXPECT_NE(error({folder_ / "out.mp4"}).find("no moving picture"), std::string::npos);
  EXPECT_NE(error({folder_ / "a.wav", folder_ / "a.wav"}).find("two earpoints"), std::string::npos);
  EXPECT_NE(error({input}).find("is the recording itself"), std::string::npos);
  // Only the recording is left.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

}  // namespace
}  // namespace earpoint
