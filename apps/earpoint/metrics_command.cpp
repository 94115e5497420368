#include "metrics_command.h"

#include "json_text.h"
#include "rt60_model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/decay_metrics.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/reverberation_error.h>
#include <earpoint/evaluate/speech_metrics.h>
#include <earpoint/rt60/weights.h>

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using earpoint::Waveform;

struct MetricsOptions {
  fs::path reference;
  fs::path estimate;
  std::string variant = "vigas";
  fs::path rt60_model;
  bool impulse_responses = false;
  bool trim = false;
  bool sign_fix = false;
  bool json = false;
};

constexpr const char* kExamples = R"(
Examples:
  earpoint metrics there.wav rendered.wav
  earpoint metrics there.wav rendered.wav --json
  earpoint metrics there.wav rendered.wav --variant rwavs
  earpoint metrics near.wav dry.wav --variant speech
  earpoint metrics measured_brir.wav traced_brir.wav --impulse-responses

Zero is best, except for speech. Both sounds are binaural (left, right) and of equal length.
  mag             sum over the ears of the mean difference of STFT magnitudes
  lre_db          difference of the left-right energy ratios, dB; none if a left ear is silent
  stft_distance   sum over the ears of the Euclidean distance of the STFTs
  l2              mean squared difference of the samples
  rte_s           mean difference of the ears' T60, estimated from the sounds by a network; none
                  if models/rt60.safetensors is missing
  delay_samples   mean delay of the ears at 16 kHz, at most 50 (also for a silent ear)
--variant rwavs:
  mag             sum over the ears of the mean squared difference of STFT magnitudes, 22.05 kHz
  env             sum over the ears of the RMS difference of the Hilbert envelopes
--variant speech (any number of channels, means over them; more is better):
  si_sdr_db       scale-invariant signal-to-distortion ratio, 16 kHz; none for silence
  estoi           extended short-time objective intelligibility, at most 1; none for less than
                  0.4 s of speech
--impulse-responses (any number of channels; means of absolute differences):
  t60_error_s, t60_error_percent, edt_error_s, c50_error_db
)";

/// One line of the result: its JSON key, its value and what a table says about it.
struct Row {
  std::string key;
  Json value;
  std::string unit;
};

struct Report {
  std::vector<Row> rows;
  std::vector<std::string> notes;
  Json extra = Json::object();
};

void trim_to(Waveform& wave, std::ptrdiff_t samples) {
  if (wave.samples() <= samples) return;
  Waveform shorter(wave.channels(), samples, wave.sample_rate_hz());
  for (int c = 0; c < wave.channels(); ++c) {
    std::ranges::copy(wave.channel(c).first(static_cast<std::size_t>(samples)),
                      shorter.channel(c).begin());
  }
  wave = std::move(shorter);
}

/// Brings a sound to the rate that its metrics are published at.
void to_rate(Waveform& wave, int rate_hz, const fs::path& path, Report& report) {
  if (wave.sample_rate_hz() == rate_hz) return;
  report.notes.push_back(
      fmt::format("{} resampled from {} to {} Hz", path.string(), wave.sample_rate_hz(), rate_hz));
  wave = earpoint::resample(wave, rate_hz);
}

/// Both sounds, comparable.
struct Pair {
  Waveform reference;
  Waveform estimate;
};

/// Refuses channels that do not correspond, and samples that are no numbers.
void check_speech(const Pair& pair, const MetricsOptions& options) {
  if (pair.reference.channels() != pair.estimate.channels()) {
    throw earpoint::InputError(options.estimate.string(),
                               fmt::format("has {} channels, {} has {}", pair.estimate.channels(),
                                           options.reference.string(), pair.reference.channels()),
                               "compare sounds with the same number of channels");
  }
  for (const auto& [sound, path] : {std::pair{&pair.reference, &options.reference},
                                    std::pair{&pair.estimate, &options.estimate}}) {
    if (!std::ranges::all_of(sound->planar(), [](float x) { return std::isfinite(x); })) {
      throw earpoint::InputError(path->string(), "contains NaN or infinite samples",
                                 "write the file again");
    }
  }
}

Pair read_pair(const MetricsOptions& options, Report& report) {
  Pair pair{earpoint::read_sound(earpoint::stored_input(options.reference)),
            earpoint::read_sound(earpoint::stored_input(options.estimate))};
  const int rate_hz = options.variant == "rwavs" ? earpoint::kRwavsRateHz : earpoint::kMetricRateHz;
  to_rate(pair.reference, rate_hz, options.reference, report);
  to_rate(pair.estimate, rate_hz, options.estimate, report);
  const std::ptrdiff_t shorter = std::min(pair.reference.samples(), pair.estimate.samples());
  const std::ptrdiff_t longer = std::max(pair.reference.samples(), pair.estimate.samples());
  if (shorter != longer) {
    if (!options.trim) {
      throw earpoint::InputError(options.estimate.string(),
                                 fmt::format("has {} samples, {} has {}", pair.estimate.samples(),
                                             options.reference.string(), pair.reference.samples()),
                                 "use --trim to compare the common length");
    }
    report.notes.push_back(fmt::format("{} samples at the end left out", longer - shorter));
    trim_to(pair.reference, shorter);
    trim_to(pair.estimate, shorter);
  }
  if (options.variant == "speech") {
    check_speech(pair, options);
  } else {
    earpoint::check_comparable(pair.reference, options.reference.string(), pair.estimate,
                               options.estimate.string());
  }
  return pair;
}

/// Speech may have any number of channels.
Report compare_speech(const MetricsOptions& options) {
  Report report;
  const Pair pair = read_pair(options, report);
  const int channels = pair.reference.channels();
  earpoint::Estoi estoi;
  std::optional<double> ratio = 0.0;
  std::optional<double> intelligible = 0.0;
  const auto add = [channels](std::optional<double>& sum, const std::optional<double>& value) {
    sum = sum && value ? std::optional(*sum + *value / channels) : std::nullopt;
  };
  for (int c = 0; c < channels; ++c) {
    const auto reference = pair.reference.channel(c);
    const auto estimate = pair.estimate.channel(c);
    add(ratio, earpoint::si_sdr_db(reference, estimate));
    add(intelligible, estoi.measure(reference, estimate, earpoint::kMetricRateHz));
  }
  const auto json = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  report.rows = {{"si_sdr_db", json(ratio), "dB"}, {"estoi", json(intelligible), ""}};
  report.extra["samples"] = pair.reference.samples();
  report.extra["sample_rate_hz"] = pair.reference.sample_rate_hz();
  return report;
}

/// Adds RTE, if there is an estimator for it.
void add_reverberation_error(const MetricsOptions& options, const Pair& pair, Report& report) {
  const std::optional<fs::path> model = rt60_model(options.rt60_model);
  if (!model) {
    report.notes.emplace_back(kNoRt60Model);
    report.rows.push_back({"rte_s", Json(nullptr), "s"});
    return;
  }
  earpoint::Rt60Estimator estimator(earpoint::read_rt60_estimator_weights(*model));
  report.rows.push_back(
      {"rte_s", earpoint::reverberation_error_s(estimator, pair.reference, pair.estimate), "s"});
}

Report compare_sounds(const MetricsOptions& options) {
  Report report;
  Pair pair = read_pair(options, report);
  if (options.sign_fix) {
    const earpoint::SignFix fix =
        earpoint::fix_sign(std::span(&pair.estimate, 1), std::span(&pair.reference, 1));
    report.notes.emplace_back(fix == earpoint::SignFix::none ? "the sign fix changed nothing"
                              : fix == earpoint::SignFix::negated_left
                                  ? "the sign fix negated the left ear"
                                  : "the sign fix negated the right ear");
  }
  report.extra["samples"] = pair.reference.samples();
  report.extra["sample_rate_hz"] = pair.reference.sample_rate_hz();
  if (options.variant == "rwavs") {
    const earpoint::RwavsMetrics m = earpoint::rwavs_metrics(pair.reference, pair.estimate);
    report.rows = {{"mag", m.mag, ""}, {"env", m.env, ""}};
    return report;
  }
  const earpoint::BinauralMetrics m = earpoint::binaural_metrics(pair.reference, pair.estimate);
  if (!m.lre_db) report.notes.emplace_back("a left ear is silent, so lre_db has no value");
  report.rows = {{"mag", m.mag, ""}, {"lre_db", m.lre_db ? Json(*m.lre_db) : Json(nullptr), "dB"}};
  add_reverberation_error(options, pair, report);
  report.rows.insert(report.rows.end(), {{"stft_distance", m.stft_distance, ""},
                                         {"l2", m.l2, ""},
                                         {"delay_samples", m.delay_samples, "samples"}});
  return report;
}

Json json_of(const std::vector<earpoint::ChannelDecay>& channels) {
  Json list = Json::array();
  for (const earpoint::ChannelDecay& channel : channels) {
    list.push_back(
        {{"t60_s", channel.t60_s}, {"edt_s", channel.edt_s}, {"c50_db", channel.c50_db}});
  }
  return list;
}

Report compare_impulse_responses(const MetricsOptions& options) {
  const earpoint::DecayComparison found = earpoint::compare_decays(
      earpoint::read_sound(earpoint::stored_input(options.reference)), options.reference.string(),
      earpoint::read_sound(earpoint::stored_input(options.estimate)), options.estimate.string());
  const bool t30 = found.range == earpoint::DecayRange::t30;
  Report report;
  report.rows = {{"t60_error_s", found.t60_error_s, "s"},
                 {"t60_error_percent", found.t60_error_percent, "%"},
                 {"edt_error_s", found.edt_error_s, "s"},
                 {"c50_error_db", found.c50_error_db, "dB"}};
  report.notes.emplace_back(t30 ? "T60 is T30, read from -5 to -35 dB"
                                : "T60 is T20, read from -5 to -25 dB: not all decay to -35 dB");
  report.extra["t60_range"] = t30 ? "t30" : "t20";
  report.extra["reference"] = json_of(found.reference);
  report.extra["estimate"] = json_of(found.estimate);
  return report;
}

void print(const Report& report, bool as_json) {
  if (as_json) {
    Json json = Json::object();
    for (const Row& row : report.rows) json[row.key] = row.value;
    json.update(report.extra);
    json["notes"] = report.notes;
    fmt::print("{}\n", earpoint::json_text(json));
    return;
  }
  for (const Row& row : report.rows) {
    const std::string value =
        row.value.is_null() ? "-" : fmt::format("{:.6g}", row.value.get<double>());
    fmt::print("{:<18}{:>14}{}{}\n", row.key, value, row.unit.empty() ? "" : " ", row.unit);
  }
  for (const std::string& note : report.notes) fmt::print("note: {}\n", note);
}

}  // namespace

void add_metrics_command(CLI::App& app) {
  auto options = std::make_shared<MetricsOptions>();
  CLI::App* command = app.add_subcommand(
      "metrics", "Measure the error of an estimated sound against its reference.");
  command->add_option("reference", options->reference, "The true sound (WAV, FLAC, ...)")
      ->required();
  command->add_option("estimate", options->estimate, "The rendered sound")->required();
  command->add_flag("--json", options->json, "Print JSON");
  auto* variant = command
                      ->add_option("--variant", options->variant,
                                   "Definitions: vigas (16 kHz) or rwavs (22.05 kHz); or "
                                   "speech: SI-SDR and ESTOI")
                      ->check(CLI::IsMember({"vigas", "rwavs", "speech"}))
                      ->capture_default_str();
  auto* decays = command->add_flag("--impulse-responses", options->impulse_responses,
                                   "The sounds are impulse responses: compare T60, EDT and C50");
  decays->excludes(variant);
  command
      ->add_option("--rt60-model", options->rt60_model,
                   "Weight file of the estimator behind rte_s (default: the shipped one)")
      ->excludes(decays);
  auto* trim = command->add_flag("--trim", options->trim,
                                 "Compare sounds of different lengths over the common length");
  auto* sign_fix = command->add_flag(
      "--sign-fix", options->sign_fix,
      "First negate one ear of an estimate in opposite phase, as the published evaluation does");
  trim->excludes(decays);
  sign_fix->excludes(decays);
  command->footer(kExamples);
  command->callback([options] {
    print(options->impulse_responses     ? compare_impulse_responses(*options)
          : options->variant == "speech" ? compare_speech(*options)
                                         : compare_sounds(*options),
          options->json);
  });
}
