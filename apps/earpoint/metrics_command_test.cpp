#include "run_program.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class MetricsCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("metrics_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, const Waveform& wave) {
    write_sound(folder_ / name, wave, SampleFormat::float32);
    return (folder_ / name).string();
  }

  nlohmann::json json_of(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "metrics");
    arguments.emplace_back("--json");
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output);
  }

  void expect_refused(std::vector<std::string> arguments, const std::string& part) {
    arguments.insert(arguments.begin(), "metrics");
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
  }

  fs::path folder_;
};

Waveform noise(std::ptrdiff_t samples, int rate_hz = 16000, int channels = 2) {
  RandomStream random(1);
  Waveform wave(channels, samples, rate_hz);
  for (float& x : wave.planar()) x = static_cast<float>(0.1 * random.normal());
  return wave;
}

Waveform with_ear_scaled(Waveform wave, int ear, float factor) {
  for (float& x : wave.channel(ear)) x *= factor;
  return wave;
}

TEST_F(MetricsCommand, SpeechOfOneChannelIsJudgedAtAnyRateAndLevel) {
  Waveform other = noise(48000, 48000, 1);
  const std::string reference = write("near.wav", other);
  for (float& x : other.planar()) x *= 0.3F;
  const nlohmann::json json = json_of({reference, write("dry.wav", other), "--variant", "speech"});
  // Both are resampled to 16 kHz in float.
  EXPECT_GT(json.at("si_sdr_db"), 90.0);
  EXPECT_NEAR(json.at("estoi").get<double>(), 1.0, 1e-4);
  EXPECT_EQ(json.size(), 5U);
  expect_refused({reference, write("two.wav", noise(48000, 48000, 2)), "--variant", "speech"},
                 "has 2 channels");
}

TEST_F(MetricsCommand, PrintsTheAgreedKeys) {
  const std::string reference = write("a.wav", noise(16000));
  const std::string estimate = write("b.wav", with_ear_scaled(noise(16000), 0, 0.5F));
  const nlohmann::json json = json_of({reference, estimate});
  for (const char* key : {"mag", "lre_db", "stft_distance", "l2", "delay_samples"}) {
    EXPECT_TRUE(json.at(key).is_number()) << key;
  }
  EXPECT_NEAR(json.at("lre_db").get<double>(), 20.0 * std::log10(2.0), 1e-6);
  EXPECT_EQ(json.at("delay_samples"), 0.0);

  const ProgramOutcome table = run_earpoint({"metrics", reference, estimate});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_NE(table.output.find("6.0206 dB\n"), std::string::npos) << table.output;
}

/// A weight file of an estimator that says `bias_s` of silence, and another time of sound.
void write_estimator(const std::string& path, float bias_s) {
  Rt60EstimatorWeights weights{{1, {}}, {}, {}};
  for (const auto& [name, shape] : required_tensors(weights.description)) {
    const bool shifts = name.ends_with("bias") || name.ends_with("running_mean");
    const float value = name == "predictor.0.bias" ? bias_s : shifts ? 0.0F : 0.1F;
    const std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()), value);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  write_safetensors(path, to_weight_file(weights));
}

TEST_F(MetricsCommand, ReverberationErrorComesFromTheNamedEstimator) {
  const std::string reference = write("a.wav", noise(16000));
  const std::string estimate = write("b.wav", with_ear_scaled(noise(16000), 0, 0.5F));
  const std::string model = (folder_ / "rt60.safetensors").string();
  write_estimator(model, 0.3F);
  EXPECT_GT(json_of({reference, estimate, "--rt60-model", model}).at("rte_s").get<double>(), 0.0);
  EXPECT_EQ(json_of({reference, reference, "--rt60-model", model}).at("rte_s"), 0.0);
  expect_refused({reference, estimate, "--rt60-model", reference}, "safetensors");
}

TEST_F(MetricsCommand, WithoutAnEstimatorReverberationErrorIsNullAndNoted) {
  const std::string sound = write("a.wav", noise(16000));
  const ProgramOutcome outcome = run_earpoint({"metrics", sound, sound, "--json"},
                                              {"EARPOINT_MODELS_DIR=" + folder_.string()});
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_TRUE(json.at("rte_s").is_null());
  EXPECT_NE(json.at("notes").at(0).get<std::string>().find("found no rt60.safetensors"),
            std::string::npos);
}

TEST_F(MetricsCommand, SilenceGivesNullAndANote) {
  const std::string reference = write("a.wav", noise(16000));
  const std::string estimate = write("b.wav", with_ear_scaled(noise(16000), 0, 0.0F));
  const nlohmann::json json = json_of({reference, estimate});
  EXPECT_TRUE(json.at("lre_db").is_null());
  EXPECT_EQ(json.at("notes").at(0), "a left ear is silent, so lre_db has no value");
  EXPECT_EQ(json.at("delay_samples"), 25.0);
}

TEST_F(MetricsCommand, OtherRatesAreResampledAndSaidSo) {
  const std::string reference = write("a.wav", noise(48000, 48000));
  const nlohmann::json json = json_of({reference, reference});
  EXPECT_EQ(json.at("mag"), 0.0);
  EXPECT_EQ(json.at("sample_rate_hz"), 16000);
  EXPECT_EQ(json.at("samples"), 16000);
  EXPECT_EQ(json.at("notes").size(), 2U);
}

TEST_F(MetricsCommand, TrimComparesWhatBothHave) {
  const std::string longer = write("a.wav", noise(16000));
  Waveform cut(2, 15000, 16000);
  for (int c = 0; c < 2; ++c) {
    const Waveform whole = noise(16000);
    std::copy_n(whole.channel(c).begin(), 15000, cut.channel(c).begin());
  }
  const std::string shorter = write("b.wav", cut);
  expect_refused({longer, shorter}, "b.wav: has 15000 samples");
  EXPECT_EQ(json_of({longer, shorter, "--trim"}).at("l2"), 0.0);
  EXPECT_EQ(json_of({shorter, longer, "--trim"}).at("samples"), 15000);
}

TEST_F(MetricsCommand, SignFixNegatesTheWrongEar) {
  Waveform wave = noise(16000);
  std::ranges::copy(std::as_const(wave).channel(0), wave.channel(1).begin());
  const std::string reference = write("a.wav", wave);
  const std::string estimate = write("b.wav", with_ear_scaled(wave, 1, -1.0F));
  EXPECT_GT(json_of({reference, estimate}).at("l2").get<double>(), 0.01);
  EXPECT_EQ(json_of({reference, estimate, "--sign-fix"}).at("l2"), 0.0);
}

TEST_F(MetricsCommand, RwavsVariantHasItsOwnKeys) {
  const std::string reference = write("a.wav", noise(22050, 22050));
  const std::string estimate = write("b.wav", with_ear_scaled(noise(22050, 22050), 0, 0.5F));
  const nlohmann::json json = json_of({reference, estimate, "--variant", "rwavs"});
  EXPECT_GT(json.at("mag").get<double>(), 0.0);
  EXPECT_GT(json.at("env").get<double>(), 0.0);
  EXPECT_FALSE(json.contains("lre_db"));
  EXPECT_EQ(json.at("sample_rate_hz"), 22050);
}

TEST_F(MetricsCommand, ImpulseResponsesAreComparedByTheirDecays) {
  const auto decay = [](double t60_s) {
    Waveform wave(2, 16000, 16000);
    for (int c = 0; c < 2; ++c) {
      for (int n = 0; n < 16000; ++n) {
        wave.channel(c)[n] = static_cast<float>((n % 2 == 0 ? 1.0 : -1.0) *
                                                std::pow(10.0, -3.0 * n / 16000.0 / t60_s));
      }
    }
    return wave;
  };
  const std::string reference = write("a.wav", decay(0.4));
  const std::string estimate = write("b.wav", decay(0.5));
  const nlohmann::json json = json_of({reference, estimate, "--impulse-responses"});
  // The end that is cut off bends the decay: 0.1 % of either time, twice that of their ratio.
  EXPECT_NEAR(json.at("t60_error_s").get<double>(), 0.1, 1e-3);
  EXPECT_NEAR(json.at("t60_error_percent").get<double>(), 25.0, 0.3);
  EXPECT_EQ(json.at("t60_range"), "t30");
  EXPECT_EQ(json.at("reference").size(), 2U);
  expect_refused({reference, write("c.wav", noise(16000)), "--impulse-responses"},
                 "c.wav: channel 0: impulse response: does not decay");
  EXPECT_EQ(
      run_earpoint({"metrics", reference, estimate, "--impulse-responses", "--trim"}).exit_code, 2);
}

TEST_F(MetricsCommand, TheConventionPaperIsTheDefaultByteForByte) {
  const std::string reference = write("a.wav", noise(16000));
  const std::string estimate = write("b.wav", with_ear_scaled(noise(16000), 0, 0.5F));
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, std::vector<std::string>{"--json"}}) {
    std::vector<std::string> plain{"metrics", reference, estimate};
    plain.insert(plain.end(), more.begin(), more.end());
    std::vector<std::string> named = plain;
    named.insert(named.end(), {"--convention", "paper"});
    EXPECT_EQ(run_earpoint(named).output, run_earpoint(plain).output);
  }
  EXPECT_EQ(json_of({reference, estimate, "--convention", "rwavs"}),
            json_of({reference, estimate, "--variant", "rwavs"}));
}

TEST_F(MetricsCommand, ConventionsOfImpulseResponsesHaveTheirKeys) {
  const fs::path sounds = fs::path(EARPOINT_SOURCE_DIR) / "lab/evaluate/testdata/conventions";
  const std::string reference = (sounds / "rir_reference.wav").string();
  const std::string estimate = (sounds / "rir_estimate.wav").string();
  const std::map<std::string, std::vector<std::string>> keys{
      {"raf", {"stft_error", "t60_error_percent", "edt_error_s", "c50_error_db"}},
      {"naf", {"spectral_loss", "t60_error_percent"}},
      {"avr",
       {"phase", "amp", "env", "t60_error_percent", "edt_error_s", "c50_error_db", "multi_stft"}},
      {"iso",
       {"edt_error_percent", "t20_error_percent", "t30_error_percent", "c50_error_db",
        "c80_error_db", "d50_error", "ts_error_ms"}}};
  const auto released = nlohmann::json::parse(read_text_file(sounds / "released.json"));
  for (const auto& [convention, names] : keys) {
    const nlohmann::json json = json_of({reference, estimate, "--convention", convention});
    for (const std::string& name : names) {
      EXPECT_GT(json.at(name).get<double>(), 0.0) << convention << " " << name;
    }
  }
  // The files hold 0.4 s; raf takes the first 0.32 s unless told otherwise.
  const nlohmann::json raf = json_of({reference, estimate, "--convention", "raf"});
  const double expected = released.at("raf").at("at_48_khz").at("stft_error");
  EXPECT_NEAR(raf.at("stft_error").get<double>(), expected, 1e-4 * expected);
  EXPECT_EQ(raf.at("samples"), 15360);
  EXPECT_EQ(json_of({reference, estimate, "--convention", "raf", "--length", "0.4"}).at("samples"),
            19200);
  const nlohmann::json naf = json_of({reference, estimate, "--convention", "naf"});
  EXPECT_EQ(naf.at("sample_rate_hz"), 22050);
  EXPECT_EQ(naf.at("notes").size(), 2U);
  const nlohmann::json iso = json_of({reference, estimate, "--convention", "iso"});
  EXPECT_EQ(iso.at("reference").at(0).size(), 6U);
  EXPECT_EQ(iso.at("reference").at(0).at(0).at("centre_hz"), 125.0);
}

TEST_F(MetricsCommand, AConventionThatDoesNotFitGivesOneLine) {
  const fs::path sounds = fs::path(EARPOINT_SOURCE_DIR) / "lab/evaluate/testdata/conventions";
  const std::string response = (sounds / "rir_reference.wav").string();
  const std::string noisy = write("a.wav", noise(48000, 48000, 1));
  expect_refused({noisy, response, "--convention", "raf"},
                 "a.wav: channel 0 is not an impulse response");
  expect_refused({response, write("b.wav", noise(48000, 48000)), "--convention", "avr"},
                 "b.wav: has 2 channels");
  expect_refused({response, write("c.wav", noise(16000, 16000, 1)), "--convention", "iso"},
                 "c.wav: has 16000 Hz");
  expect_refused({response, response, "--convention", "raf", "--trim"}, "--trim");
  expect_refused({response, response, "--convention", "rwavs"}, "has 1 channel");
  expect_refused({noisy, noisy, "--convention", "paper", "--length", "1"}, "--length");
  EXPECT_EQ(
      run_earpoint({"metrics", response, response, "--convention", "naf", "--variant", "rwavs"})
          .exit_code,
      2);
}

TEST_F(MetricsCommand, BadInputGivesOneLine) {
  const std::string good = write("a.wav", noise(16000));
  expect_refused({good, (folder_ / "missing.wav").string()}, "missing.wav: no such file");
  write_file(folder_ / "text.wav", "not a sound");
  expect_refused({(folder_ / "text.wav").string(), good}, "text.wav: is not a readable sound file");
  expect_refused({good, write("mono.wav", noise(16000, 16000, 1))}, "mono.wav: has 1 channel");
}

TEST_F(MetricsCommand, HelpTeachesByExample) {
  const ProgramOutcome help = run_earpoint({"metrics", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.output.find("earpoint metrics there.wav rendered.wav --json"), std::string::npos);
  EXPECT_EQ(run_earpoint({"metrics"}).exit_code, 2);
}

}  // namespace

}  // namespace earpoint
