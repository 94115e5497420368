#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/response_metrics.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

// The released evaluations sum in single precision, some of them thousands of numbers: 1e-4 of a
// value is ten times what that can lose.
constexpr double kRelative = 1e-4;

fs::path conventions() {
  return fs::path(EARPOINT_SOURCE_DIR) / "lab/evaluate/testdata/conventions";
}

nlohmann::json released() {
  return nlohmann::json::parse(read_text_file(conventions() / "released.json"));
}

/// Every `step`-th of the first `samples`.
Waveform part_of(const Waveform& wave, std::ptrdiff_t samples, int step) {
  Waveform part(wave.channels(), samples / step, wave.sample_rate_hz() / step);
  for (int c = 0; c < wave.channels(); ++c) {
    for (std::ptrdiff_t i = 0; i < part.samples(); ++i) {
      part.channel(c)[i] = wave.channel(c)[i * step];
    }
  }
  return part;
}

ResponsePair pair_of(const std::string& kind) {
  return {read_sound(conventions() / (kind + "_reference.wav")),
          read_sound(conventions() / (kind + "_estimate.wav"))};
}

ResponsePair part_of(const ResponsePair& pair, std::ptrdiff_t samples, int step) {
  return {part_of(pair.reference, samples, step), part_of(pair.estimate, samples, step)};
}

/// The estimate that record_released.py calls cut off.
Waveform cut_off(const Waveform& like) {
  Waveform wave(like.channels(), like.samples(), like.sample_rate_hz());
  for (int c = 0; c < wave.channels(); ++c) {
    for (int i = 0; i < 25; ++i) {
      wave.channel(c)[wave.samples() - 25 + i] = i % 2 == 0 ? 0.5F : -0.5F;
    }
  }
  return wave;
}

void expect_near(const std::optional<double>& found, const nlohmann::json& expected,
                 const char* name) {
  ASSERT_EQ(found.has_value(), expected.is_number()) << name;
  if (!found) return;
  const double value = expected.get<double>();
  EXPECT_GT(value, 0.0) << name;
  EXPECT_NEAR(*found, value, kRelative * value) << name;
}

void expect_raf(const ResponsePair& pair, const nlohmann::json& expected) {
  const RafMetrics found = raf_metrics(pair);
  expect_near(found.stft_error, expected.at("stft_error"), "stft_error");
  expect_near(found.t60_error_percent, expected.at("t60_error_percent"), "t60");
  expect_near(found.edt_error_s, expected.at("edt_error_s"), "edt");
  expect_near(found.c50_error_db, expected.at("c50_error_db"), "c50");
  EXPECT_EQ(found.t60_invalid, expected.at("t60_invalid").get<bool>());
}

TEST(RafMetrics, AreTheReleasedOnes) {
  const nlohmann::json expected = released().at("raf");
  const ResponsePair pair = part_of(pair_of("rir"), 15360, 1);
  expect_raf(pair, expected.at("at_48_khz"));
  expect_raf(part_of(pair, 15360, 3), expected.at("at_16_khz"));
  expect_raf({pair.reference, cut_off(pair.reference)}, expected.at("cut_off"));
  EXPECT_TRUE(expected.at("cut_off").at("t60_invalid"));
}

TEST(NafMetrics, AreTheReleasedOnes) {
  const nlohmann::json expected = released().at("naf");
  const ResponsePair pair = pair_of("brir");
  const NafMetrics found = naf_metrics(pair);
  expect_near(found.spectral_loss, expected.at("spectral_loss"), "spectral_loss");
  expect_near(found.t60_error_percent, expected.at("t60_error_percent"), "t60");
  EXPECT_FALSE(found.t60_invalid);
  const NafMetrics late = naf_metrics({pair.reference, cut_off(pair.reference)});
  EXPECT_TRUE(expected.at("cut_off").at("t60_invalid"));
  EXPECT_TRUE(late.t60_invalid);
  EXPECT_EQ(late.t60_error_percent, expected.at("cut_off").at("t60_error_percent").get<double>());
}

void expect_avr(const ResponsePair& pair, const nlohmann::json& expected) {
  const AvrMetrics found = avr_metrics(pair);
  expect_near(found.phase, expected.at("phase"), "phase");
  expect_near(found.amp, expected.at("amp"), "amp");
  expect_near(found.env, expected.at("env"), "env");
  expect_near(*found.t60_error_percent / 100.0, expected.at("t60_error_ratio"), "t60");
  expect_near(found.edt_error_s, expected.at("edt_error_s"), "edt");
  expect_near(found.c50_error_db, expected.at("c50_error_db"), "c50");
  expect_near(found.multi_stft, expected.at("multi_stft"), "multi_stft");
}

TEST(AvrMetrics, AreTheReleasedOnes) {
  const nlohmann::json expected = released().at("avr");
  expect_avr(part_of(pair_of("rir"), 4800, 3), expected.at("at_16_khz"));
  expect_avr(pair_of("brir"), expected.at("two_channels"));
}

TEST(RwavsMetrics, AreTheReleasedOnes) {
  const nlohmann::json expected = released().at("rwavs");
  const ResponsePair pair = pair_of("speech");
  const RwavsMetrics found = rwavs_metrics(pair.reference, pair.estimate);
  expect_near(found.mag, expected.at("mag"), "mag");
  expect_near(found.env, expected.at("env"), "env");
}

TEST(ResponseMetrics, OfEqualResponsesAreZero) {
  const ResponsePair rir = part_of(pair_of("rir"), 15360, 1);
  const RafMetrics raf = raf_metrics({rir.reference, rir.reference});
  EXPECT_EQ(raf.stft_error + *raf.t60_error_percent + *raf.edt_error_s + *raf.c50_error_db, 0.0);
  const AvrMetrics avr = avr_metrics({rir.reference, rir.reference});
  EXPECT_EQ(avr.phase + avr.amp + avr.env + *avr.t60_error_percent + avr.edt_error_s +
                *avr.c50_error_db + avr.multi_stft,
            0.0);
  const ResponsePair brir = pair_of("brir");
  const NafMetrics naf = naf_metrics({brir.reference, brir.reference});
  EXPECT_EQ(naf.spectral_loss + *naf.t60_error_percent, 0.0);
}

std::string message_of(const auto& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

Waveform noise(std::ptrdiff_t samples, int rate_hz, int channels = 1) {
  RandomStream random(1);
  Waveform wave(channels, samples, rate_hz);
  for (float& x : wave.planar()) x = static_cast<float>(0.1 * random.normal());
  return wave;
}

TEST(ResponsePair, IsCutToTheLengthAndFilledWithZeros) {
  const ResponsePair rir = pair_of("rir");
  const ResponsePair pair =
      response_pair(rir.reference, "a", part_of(rir.estimate, 1000, 1), "b", 0.1);
  EXPECT_EQ(pair.reference.samples(), 4800);
  EXPECT_EQ(pair.estimate.samples(), 4800);
  EXPECT_EQ(pair.estimate.channel(0)[999], rir.estimate.channel(0)[999]);
  EXPECT_TRUE(std::ranges::all_of(pair.estimate.channel(0).subspan(1000),
                                  [](float x) { return x == 0.0F; }));
}

TEST(ResponsePair, RefusesWhatIsNoImpulseResponse) {
  const ResponsePair rir = pair_of("rir");
  const auto message = [&](const Waveform& reference, const Waveform& estimate) {
    return message_of([&] { (void)response_pair(reference, "a", estimate, "b", {}); });
  };
  EXPECT_EQ(message(noise(48000, 48000), rir.estimate),
            "a: channel 0 is not an impulse response: it does not decay after its loudest sample");
  EXPECT_EQ(message(rir.reference, noise(100, 48000, 2)), "b: has 2 channels, a has 1");
  EXPECT_EQ(message(rir.reference, noise(100, 16000)),
            "b: has 16000 Hz, a has 48000 Hz; resample one of them");
  EXPECT_EQ(message(Waveform(1, 100, 48000), rir.estimate), "a: channel 0 is silent");
  // An estimate may be as bad as it likes.
  EXPECT_EQ(message(rir.reference, noise(48000, 48000)), "no error");
}

TEST(ResponsePair, TheOnlyRatesOfRafAndNafAreTheirs) {
  const ResponsePair rir = pair_of("rir");
  EXPECT_EQ(message_of([&] { (void)naf_metrics(rir); }),
            "impulse responses: are at 48000 Hz, naf is defined at 22050 Hz");
  EXPECT_EQ(message_of([&] { (void)raf_metrics(pair_of("brir")); }),
            "impulse responses: are at 22050 Hz, raf is defined at 48 and 16 kHz");
  EXPECT_EQ(message_of([&] { (void)avr_metrics(part_of(rir, 256, 1)); }),
            "impulse responses: have 256 samples, avr needs 257");
}

}  // namespace
}  // namespace earpoint
